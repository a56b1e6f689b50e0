// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "datasets/session/session_verify.h"
#include "tests/datasets/import/import_fixtures.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kName = "S001C002P003R002A013.skeleton";

std::string body_text(int frame, const std::string& id = "72057594037931648",
                      const std::string& state = "2") {
  std::string text = id + " 0 1 3 0 2 0 0.25 -0.125 2\n25\n";
  for (int j = 0; j < kJointCount; ++j) {
    const auto p = made_up_joint_m(frame, j);
    text += fmt::format("{} {} {} {} {} 900 500 0.9 0.1 0.2 0.3 {}\n", p[0], p[1], p[2],
                        256.34 + 366.3 * p[0] / p[2], 208.49 - 366.5 * p[1] / p[2], state);
  }
  return text;
}

std::string frame_text(const std::vector<std::string>& bodies) {
  std::string text = std::to_string(bodies.size()) + "\n";
  for (const std::string& body : bodies) text += body;
  return text;
}

TEST(NtuImport, GivesBodiesWithExactIdsAndTurnsQuaternionsRound) {
  const ScratchFolder folder;
  const auto file = text_file(folder, kName, "2\n" + frame_text({body_text(0)}) + frame_text({body_text(1)}));
  const Imported result = imported(folder, "ntu", {file});
  EXPECT_EQ(result.session.header().sensors[0].name, "C002");
  const auto frames = result.frames();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].stamp.arrival_ns, 33'333'300);
  const Body& body = frames[1].bodies.at(0);
  EXPECT_EQ(body.tracking_id, 72057594037931648u);
  EXPECT_THAT(body.orientation_xyzw[5], ElementsAre(0.1f, 0.2f, 0.3f, 0.9f));
  EXPECT_THAT(body.hand_confidence, ElementsAre(1, 0));
  EXPECT_THAT(body.hand_state, ElementsAre(3, 2));
  EXPECT_EQ(body.position_m[5][0], static_cast<float>(made_up_joint_m(1, 5)[0]));
}

TEST(NtuImport, FindsTheCameraOfEachFile) {
  const ScratchFolder folder;
  std::string text = "20\n";
  for (int i = 0; i < 20; ++i) text += frame_text({body_text(i)});
  const Imported result = imported(folder, "ntu", {text_file(folder, kName, text)});
  const DepthIntrinsics& camera = result.session.header().sensors[0].intrinsics;
  EXPECT_NEAR(camera.fx_px, 366.3, 1e-3);
  EXPECT_NEAR(camera.fy_px, 366.5, 1e-3);
  EXPECT_NEAR(camera.cx_px, 256.34, 1e-3);
  EXPECT_NEAR(camera.cy_px, 208.49, 1e-3);
}

TEST(NtuImport, TakesFramesWithThreeBodiesAndWithNone) {
  const ScratchFolder folder;
  const auto file = text_file(
      folder, kName,
      "2\n" + frame_text({}) + frame_text({body_text(0, "1"), body_text(1, "2"), body_text(2, "3")}));
  const auto frames = imported(folder, "ntu", {file}).frames();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].bodies.size(), 0u);
  EXPECT_EQ(frames[1].bodies.size(), 3u);
}

TEST(NtuImport, AllCamerasOfARecordingAreOneSession) {
  const ScratchFolder folder;
  std::vector<std::filesystem::path> files;
  for (const char* camera : {"C001", "C002", "C003"})
    files.push_back(text_file(folder, std::string("S001") + camera + "P003R002A013.skeleton",
                              "1\n" + frame_text({body_text(0)})));
  const Imported result = imported(folder, "ntu", files);
  ASSERT_EQ(result.session.header().sensors.size(), 3u);
  EXPECT_EQ(result.session.header().sensors[2].name, "C003");
  EXPECT_EQ(result.session.counts(2).body_frames, 1u);
}

// Camera C002 has a torn frame.
TEST(NtuImport, EqualFrameNumbersOfThreeCamerasAreTheSameMoment) {
  const ScratchFolder folder;
  std::vector<std::filesystem::path> files;
  for (const char* camera : {"C003", "C001", "C002"}) {
    std::string text = "20\n";
    for (int i = 0; i < 20; ++i) {
      std::string frame = frame_text({body_text(i)});
      if (i == 7 && camera == std::string("C002")) frame.replace(frame.rfind(" 0.3 2\n"), 6, "");
      text += frame;
    }
    files.push_back(text_file(folder, std::string("S001") + camera + "P003R002A013.skeleton", text));
  }
  const Imported result = imported(folder, "ntu", files);
  ASSERT_EQ(result.session.header().sensors.size(), 3u);
  EXPECT_EQ(result.session.header().sensors[1].name, "C002");
  const auto first = result.frames(0), torn = result.frames(1);
  EXPECT_EQ(first.size(), 20u);
  EXPECT_EQ(torn.size(), 19u);
  EXPECT_EQ(result.frames(2).size(), 20u);
  for (const BodyFrame& seen : torn) {
    const BodyFrame& other = first.at(static_cast<std::size_t>(seen.stamp.sequence));
    EXPECT_EQ(other.stamp.arrival_ns, seen.stamp.arrival_ns);
    EXPECT_EQ(other.bodies.at(0).position_m, seen.bodies.at(0).position_m);
  }
  EXPECT_EQ(result.report.sensors[2].name, "C002");
  EXPECT_EQ(result.report.sensors[2].gap_frames, 1);
  for (const Finding& finding : verify_session(result.session, {}))
    EXPECT_NE(finding.severity, Severity::error) << finding.text;
}

TEST(NtuImport, RefusesFilesOfDifferentRecordingsOrOneCameraTwice) {
  const ScratchFolder folder;
  const std::string text = "1\n" + frame_text({body_text(0)});
  const auto first = text_file(folder, kName, text);
  EXPECT_THAT(
      import_refusal(folder, "ntu", {first, text_file(folder, "S001C003P003R002A014.skeleton", text)}),
      HasSubstr("another recording"));
  EXPECT_THAT(import_refusal(folder, "ntu", {first, first}), HasSubstr("camera C002"));
  EXPECT_THAT(import_refusal(folder, "ntu", {first, text_file(folder, "b.skeleton", text)}),
              HasSubstr("no name"));
  EXPECT_THAT(import_refusal(folder, "ntu", {text_file(folder, "b.skeleton", text), first}),
              HasSubstr("no name"));
}

TEST(NtuImport, ATornJointCostsItsFrameAndLeavesAGap) {
  const ScratchFolder folder;
  std::string torn = frame_text({body_text(1)});
  torn.replace(torn.rfind(" 0.3 2\n"), 6, "");
  const auto file =
      text_file(folder, kName, "3\n" + frame_text({body_text(0)}) + torn + frame_text({body_text(2)}));
  const Imported result = imported(folder, "ntu", {file});
  EXPECT_THAT(sequences(result.frames()), ElementsAre(0, 2));
  EXPECT_EQ(result.report.sensors[0].left_out.torn_rows, 1);
  EXPECT_EQ(result.report.sensors[0].gap_frames, 1);
}

TEST(NtuImport, AFileThatEndsEarlySaysHowManyFramesAreLost) {
  const ScratchFolder folder;
  const auto file = text_file(folder, kName, "5\n" + frame_text({body_text(0)}) + "1\n");
  const Imported result = imported(folder, "ntu", {file});
  EXPECT_EQ(result.session.counts(0).body_frames, 1u);
  EXPECT_THAT(result.report.sensors[0].left_out.first, HasSubstr("4 of 5 frames are lost"));
}

TEST(NtuImport, TheRateIsTheUsersWhenGiven) {
  const ScratchFolder folder;
  const auto file = text_file(folder, kName, "2\n" + frame_text({}) + frame_text({}));
  EXPECT_EQ(imported(folder, "ntu", {file}, {.rate_hz = 15.0}).frames()[1].stamp.arrival_ns, 66'666'700);
}

TEST(NtuImport, PixelsThatTheSdkCouldNotProjectDoNoHarm) {
  const ScratchFolder folder;
  std::string body = body_text(0);
  const auto line = body.find("\n25\n") + 4;
  std::size_t begin = line;
  for (int skipped = 0; skipped < 3; ++skipped) begin = body.find(' ', begin) + 1;
  const std::size_t end = body.find(' ', body.find(' ', begin) + 1);
  body.replace(begin, end - begin, "-inf NaN");
  const Imported result = imported(folder, "ntu", {text_file(folder, kName, "1\n" + frame_text({body}))});
  EXPECT_EQ(result.session.counts(0).body_frames, 1u);
}

TEST(NtuImport, RefusesOtherAndAveragedFiles) {
  const ScratchFolder folder;
  const auto refusal = [&](const std::string& text) {
    return import_refusal(folder, "ntu", {text_file(folder, kName, text)});
  };
  EXPECT_THAT(refusal(""), HasSubstr("no .skeleton file"));
  EXPECT_THAT(refusal("frame,time\n"), HasSubstr("skeleton:1"));
  EXPECT_THAT(refusal("0\n"), HasSubstr("no frame"));
  EXPECT_THAT(refusal("99999999999\n"), HasSubstr("99999999999"));
  EXPECT_THAT(refusal("1\n" + frame_text({body_text(0, "1", "1.25")})), HasSubstr("averaged"));
}

}  // namespace
}  // namespace trilat
