// SPDX-License-Identifier: MIT
// Files of the published form, made up here.
#include <gmock/gmock.h>

#include "tests/datasets/import/import_fixtures.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

std::string taichi_row(int frame, const std::string& time_ms, int joints = kJointCount) {
  std::string text = time_ms;
  for (int j = 0; j < joints; ++j) {
    const auto p = made_up_joint_m(frame, j);
    text += fmt::format(" {} {} {}", p[0], p[1], p[2]);
  }
  return text + "\n";
}

TEST(UmonsTaichiImport, GivesPositionsAndTimesAndSaysWhatIsAssumed) {
  const ScratchFolder folder;
  const auto file =
      text_file(folder, "P01T01C01.txt", taichi_row(0, "0") + taichi_row(1, "33") + taichi_row(3, "100"));
  const Imported result = imported(folder, "umons-taichi", {file});
  const auto frames = result.frames();
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[1].stamp.device_ticks, 330'000);
  EXPECT_EQ(frames[1].stamp.arrival_ns, 33'000'000);
  EXPECT_THAT(sequences(frames), ElementsAre(0, 1, 3));
  const Body& body = frames[1].bodies.at(0);
  EXPECT_THAT(body.tracking_state, Each(2));
  for (std::size_t axis = 0; axis < 3; ++axis)
    EXPECT_EQ(body.position_m[24][axis], static_cast<float>(made_up_joint_m(1, 24)[axis]));
  EXPECT_THAT(result.session.header().note,
              AllOf(HasSubstr("no tracking states"), HasSubstr("not yet been run on a real file")));
  EXPECT_EQ(result.report.sensors[0].left_out.total(), 0);
}

TEST(UmonsTaichiImport, TakesTabsRunsOfBlanksAndWindowsLineEnds) {
  const ScratchFolder folder;
  std::string text = taichi_row(0, "  5 ") + taichi_row(1, "38");
  text.replace(text.find(" 0."), 1, "\t ");
  text.insert(text.find('\n'), " \r");
  EXPECT_EQ(imported(folder, "umons-taichi", {text_file(folder, "a.txt", text)}).frames().size(), 2u);
}

// A bad line is left out, and the report names it.
TEST(UmonsTaichiImport, NamesTheLineThatIsBad) {
  std::string with_nan = taichi_row(1, "33");
  with_nan.replace(with_nan.rfind(' ') + 1, std::string::npos, "NaN\n");
  const std::vector<std::pair<std::string, std::string>> bad_lines{
      {taichi_row(1, "33", 24), "has 73 cells; a row has 76: the time, then x, y, z of 25 joints"},
      {taichi_row(1, "-10"), "has a time before that of the frame before"},
      {with_nan, "has \"NaN\" where a joint's position should be"},
      {taichi_row(1, "33.5"), "has \"33.5\" where the time in whole milliseconds should be"},
      {taichi_row(1, "9223372036854775807"), "beyond all clocks"}};
  for (const auto& [line, problem] : bad_lines) {
    const ScratchFolder folder;
    const Imported result =
        imported(folder, "umons-taichi",
                 {text_file(folder, "a.txt", taichi_row(0, "0") + line + taichi_row(2, "67"))});
    EXPECT_EQ(result.frames().size(), 2u) << problem;
    EXPECT_EQ(result.report.sensors[0].left_out.total(), 1) << problem;
    EXPECT_THAT(result.report.sensors[0].left_out.first, AllOf(HasSubstr("a.txt:2"), HasSubstr(problem)));
  }
}

TEST(UmonsTaichiImport, RefusesAFileOfOtherRowsWithOneError) {
  const ScratchFolder folder;
  const auto refusal = [&](const std::string& text) {
    return import_refusal(folder, "umons-taichi", {text_file(folder, "a.txt", text)});
  };
  EXPECT_THAT(refusal(taichi_row(0, "0", 24)), AllOf(HasSubstr("a.txt:1"), HasSubstr("has 73 cells")));
  EXPECT_THAT(refusal(""), HasSubstr("no frame"));
  std::string millimetres = "0";
  for (int j = 0; j < kJointCount; ++j) millimetres += " 100 200 2500";
  EXPECT_THAT(refusal(millimetres + "\n"), AllOf(HasSubstr("a.txt:1"), HasSubstr("metres")));
}

}  // namespace
}  // namespace trilat
