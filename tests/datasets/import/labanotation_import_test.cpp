// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "datasets/session/session_verify.h"
#include "tests/datasets/import/import_fixtures.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::int64_t kFramePeriodTicks = 333'333;

std::string row(int frame, std::int64_t ticks, const std::string& state = "2") {
  std::string text = std::to_string(ticks);
  for (int j = 0; j < kJointCount; ++j) {
    const auto p = made_up_joint_m(frame, j);
    text += fmt::format(",{},{},{},{}", p[0], p[1], p[2], state);
  }
  return text + ",\n";
}

TEST(LabanotationImport, GivesPositionsStatesAndTimesAsTheyAreWritten) {
  const ScratchFolder folder;
  const auto file = text_file(folder, "a.csv", row(0, 31'867'373'716) + row(1, 31'867'707'049, "1"));
  const Imported result = imported(folder, "labanotation", {file});
  const auto frames = result.frames();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].stamp.device_ticks, 31'867'707'049);
  EXPECT_EQ(frames[1].stamp.arrival_ns, 3'186'770'704'900);
  ASSERT_EQ(frames[1].bodies.size(), 1u);
  const Body& body = frames[1].bodies[0];
  const auto expected = made_up_joint_m(1, 7);
  for (std::size_t axis = 0; axis < 3; ++axis)
    EXPECT_EQ(body.position_m[7][axis], static_cast<float>(expected[axis]));
  EXPECT_EQ(body.tracking_state[7], 1);
  EXPECT_EQ(frames[0].bodies[0].tracking_state[7], 2);
  EXPECT_EQ(result.session.header().sensors[0].source, "import labanotation");
  EXPECT_FALSE(result.session.header().simulated);
  EXPECT_TRUE(result.session.complete());
  EXPECT_EQ(result.report.sensors[0].left_out.total(), 0);
}

TEST(LabanotationImport, ALostFrameIsAGapInTheSequence) {
  const ScratchFolder folder;
  const auto file =
      text_file(folder, "a.csv", row(0, 0) + row(1, kFramePeriodTicks) + row(3, 3 * kFramePeriodTicks));
  const Imported result = imported(folder, "labanotation", {file});
  EXPECT_THAT(sequences(result.frames()), ElementsAre(0, 1, 3));
  EXPECT_EQ(result.report.sensors[0].gap_frames, 1);
}

TEST(LabanotationImport, JitterOfTheTimesIsNoGap) {
  const ScratchFolder folder;
  const auto file =
      text_file(folder, "a.csv", row(0, 0) + row(1, 260'000) + row(2, 700'000) + row(3, 1'000'000));
  EXPECT_THAT(sequences(imported(folder, "labanotation", {file}).frames()), ElementsAre(0, 1, 2, 3));
}

TEST(LabanotationImport, CountsTornRowsAndNamesTheFirst) {
  const ScratchFolder folder;
  std::string cut = row(2, 2 * kFramePeriodTicks);
  cut.resize(cut.size() / 2);
  const auto file = text_file(folder, "a.csv", row(0, 0) + "1,2,3\n" + row(1, kFramePeriodTicks) + cut);
  const Imported result = imported(folder, "labanotation", {file});
  EXPECT_EQ(result.session.counts(0).body_frames, 2u);
  EXPECT_EQ(result.report.sensors[0].left_out.torn_rows, 2);
  EXPECT_THAT(result.report.sensors[0].left_out.first, HasSubstr("a.csv:2 has 3 cells"));
}

TEST(LabanotationImport, LeavesOutTimesThatRepeatOrGoBack) {
  const ScratchFolder folder;
  const auto file = text_file(folder, "a.csv",
                              row(0, 1000) + row(1, 1000) + row(2, 500) + row(3, 1000 + kFramePeriodTicks));
  const Imported result = imported(folder, "labanotation", {file});
  EXPECT_EQ(result.session.counts(0).body_frames, 2u);
  EXPECT_EQ(result.report.sensors[0].left_out.repeated_times, 1);
  EXPECT_EQ(result.report.sensors[0].left_out.backward_times, 1);
  EXPECT_THAT(result.report.sensors[0].left_out.first, HasSubstr("a.csv:2"));
}

TEST(LabanotationImport, TakesWindowsLineEndsAndALastLineWithoutOne) {
  const ScratchFolder folder;
  std::string text = row(0, 0) + row(1, kFramePeriodTicks);
  text.pop_back();
  text.insert(text.find('\n'), "\r");
  const Imported result = imported(folder, "labanotation", {text_file(folder, "a.csv", text)});
  EXPECT_EQ(result.session.counts(0).body_frames, 2u);
  EXPECT_EQ(result.report.sensors[0].left_out.total(), 0);
}

TEST(LabanotationImport, RefusesAnAveragedFile) {
  const ScratchFolder folder;
  const auto file = text_file(folder, "a.csv", row(0, 0) + row(1, kFramePeriodTicks, "1.5"));
  EXPECT_THAT(import_refusal(folder, "labanotation", {file}),
              testing::AllOf(HasSubstr("a.csv:2"), HasSubstr("1.5"), HasSubstr("averaged")));
}

TEST(LabanotationImport, RefusesMillimetres) {
  const ScratchFolder folder;
  std::string text = "0";
  for (int j = 0; j < kJointCount; ++j) text += ",100,200,2500,2";
  EXPECT_THAT(import_refusal(folder, "labanotation", {text_file(folder, "a.csv", text)}),
              testing::AllOf(HasSubstr("a.csv:1"), HasSubstr("metres")));
}

TEST(LabanotationImport, RefusesWhatHoldsNoRow) {
  const ScratchFolder folder;
  EXPECT_THAT(import_refusal(folder, "labanotation", {text_file(folder, "empty.csv", "")}),
              HasSubstr("no frame"));
  EXPECT_THAT(import_refusal(folder, "labanotation", {text_file(folder, "other.csv", "frame,time\n0,1\n")}),
              HasSubstr("other.csv:1 has 2 cells"));
  EXPECT_THAT(import_refusal(folder, "labanotation", {folder / "absent.csv"}), HasSubstr("cannot be opened"));
  EXPECT_THAT(import_refusal(folder, "labanotation", {}), HasSubstr("missing"));
  EXPECT_THAT(import_refusal(folder, "labanotation",
                             {text_file(folder, "a.csv", row(0, 0)), text_file(folder, "b.csv", row(0, 0))}),
              HasSubstr("b.csv"));
}

TEST(LabanotationImport, RefusesARateForAFileThatHasTimes) {
  const ScratchFolder folder;
  EXPECT_THAT(
      import_refusal(folder, "labanotation", {text_file(folder, "a.csv", row(0, 0))}, {.rate_hz = 30.0}),
      HasSubstr("--rate-hz"));
}

struct RealFile {
  const char* path;
  std::uint64_t frames;
  std::int64_t gap_frames;
};

// Rows and steps of two periods were counted with awk.
TEST(LabanotationImport, TakesEveryFrameOfTheRealFiles) {
  for (const RealFile& file :
       {RealFile{"joints.csv", 371, 2}, RealFile{"Ges01_wavehand.csv", 154, 2},
        RealFile{"Ges02_balancinghands.csv", 161, 2}, RealFile{"Ges03_drawlines.csv", 213, 5},
        RealFile{"Ges04_comehere.csv", 172, 5}, RealFile{"Ges05_demopoint.csv", 190, 2},
        RealFile{"Ges06_chickenwing.csv", 160, 1}}) {
    const auto path = shared_recordings() / "labanotation" / file.path;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path.string() << " is not there";
    const ScratchFolder folder;
    const Imported result = imported(folder, "labanotation", {path});
    EXPECT_EQ(result.session.counts(0).body_frames, file.frames) << file.path;
    EXPECT_EQ(result.report.sensors[0].gap_frames, file.gap_frames) << file.path;
    EXPECT_EQ(result.report.sensors[0].left_out.total(), 0) << file.path;
    for (const Finding& finding : verify_session(result.session, {}))
      EXPECT_NE(finding.severity, Severity::error) << finding.text;
  }
}

}  // namespace
}  // namespace trilat
