// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "datasets/import/node_kinect2_reader.h"
#include "tests/datasets/import/import_fixtures.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// As the recorder writes a body; the pixels are those of a camera with 365 px and its centre at (256, 212).
std::string element(int frame, int time_ms, const std::string& id = "72057594037931648",
                    const std::string& tracked = "true") {
  std::string joints;
  for (int j = 0; j < kJointCount; ++j) {
    const auto p = made_up_joint_m(frame, j);
    joints += fmt::format(
        R"({}{{"depthX":{},"depthY":{},"colorX":0.5,"colorY":0.5,"cameraX":{},"cameraY":{},"cameraZ":{},)"
        R"("orientationX":0.1,"orientationY":0.2,"orientationZ":0.3,"orientationW":0.9}})",
        j == 0 ? "" : ",", (256.0 + 365.0 * p[0] / p[2]) / 512.0, (212.0 - 365.0 * p[1] / p[2]) / 424.0, p[0],
        p[1], p[2]);
  }
  return fmt::format(R"({{"bodyIndex":0,"tracked":{},"trackingId":"{}","leftHandState":3,"rightHandState":2,)"
                     R"("joints":[{}],"record_startime":1518026639637,"record_timestamp":{}}})",
                     tracked, id, joints, time_ms);
}

std::string walk(int frames) {
  std::string text = "[";
  for (int i = 0; i < frames; ++i) text += (i == 0 ? "" : ",") + element(i, 33 * i + i / 3);
  return text + "]";
}

TEST(NodeKinect2Import, GivesPositionsOrientationsHandsAndTimes) {
  const ScratchFolder folder;
  const auto file = text_file(folder, "a.json", "[" + element(0, 11) + ",\n " + element(1, 44) + "]\n");
  const Imported result = imported(folder, "node-kinect2", {file});
  const auto frames = result.frames();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].stamp.arrival_ns, 11'000'000);
  EXPECT_EQ(result.session.header().started_utc, "2018-02-07T18:03:59.637Z");
  EXPECT_EQ(frames[1].stamp.device_ticks - frames[0].stamp.device_ticks, 330'000);
  const Body& body = frames[1].bodies.at(0);
  EXPECT_EQ(body.tracking_id, 72057594037931648u);
  EXPECT_EQ(body.position_m[3][2], static_cast<float>(made_up_joint_m(1, 3)[2]));
  EXPECT_THAT(body.orientation_xyzw[3], ElementsAre(0.1f, 0.2f, 0.3f, 0.9f));
  EXPECT_THAT(body.hand_state, ElementsAre(3, 2));
  EXPECT_EQ(body.tracking_state[3], 2);
  EXPECT_THAT(result.session.header().note, HasSubstr("no tracking states"));
}

TEST(NodeKinect2Import, FindsTheCameraThatThePixelsShow) {
  const ScratchFolder folder;
  const Imported result = imported(folder, "node-kinect2", {text_file(folder, "a.json", walk(20))});
  const DepthIntrinsics& camera = result.session.header().sensors[0].intrinsics;
  ASSERT_TRUE(result.report.sensors[0].intrinsics_rms_px.has_value());
  EXPECT_LT(*result.report.sensors[0].intrinsics_rms_px, 1e-3);
  EXPECT_NEAR(camera.fx_px, 365.0, 0.01);
  EXPECT_NEAR(camera.fy_px, 365.0, 0.01);
  EXPECT_NEAR(camera.cx_px, 256.0, 0.01);
  EXPECT_NEAR(camera.cy_px, 212.0, 0.01);
  EXPECT_EQ(camera.k1, 0.0);
}

TEST(NodeKinect2Import, TooFewJointsLeaveTheDefaultCamera) {
  const ScratchFolder folder;
  const Imported result = imported(folder, "node-kinect2", {text_file(folder, "a.json", walk(2))});
  EXPECT_FALSE(result.report.sensors[0].intrinsics_rms_px.has_value());
  EXPECT_EQ(result.session.header().sensors[0].intrinsics.fx_px, DepthIntrinsics{}.fx_px);
  EXPECT_THAT(result.report.note, HasSubstr("typical"));
}

TEST(NodeKinect2Import, BodiesOfOneTimeAreOneFrame) {
  const ScratchFolder folder;
  const auto file = text_file(folder, "a.json",
                              "[" + element(0, 0, "7") + "," + element(1, 0, "8") + "," + element(2, 0, "9") +
                                  "," + element(0, 33, "7") + "]");
  const auto frames = imported(folder, "node-kinect2", {file}).frames();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].bodies.size(), 3u);
  EXPECT_EQ(frames[0].bodies[2].tracking_id, 9u);
  EXPECT_EQ(frames[1].bodies.size(), 1u);
}

TEST(NodeKinect2Import, TheSameBodyTwiceAtOneTimeIsLeftOut) {
  const ScratchFolder folder;
  const auto file =
      text_file(folder, "a.json", "[" + element(0, 0) + "," + element(1, 0) + "," + element(2, 33) + "]");
  const Imported result = imported(folder, "node-kinect2", {file});
  EXPECT_EQ(result.session.counts(0).body_frames, 2u);
  EXPECT_EQ(result.report.sensors[0].left_out.repeated_times, 1);
}

TEST(NodeKinect2Import, AFrameWithoutATrackedBodyIsAFrame) {
  const ScratchFolder folder;
  const auto file =
      text_file(folder, "a.json", "[" + element(0, 0, "7", "false") + "," + element(1, 33) + "]");
  const auto frames = imported(folder, "node-kinect2", {file}).frames();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].bodies.size(), 0u);
}

TEST(NodeKinect2Import, KeepsWhatStandsBeforeTheCutOfAFile) {
  const ScratchFolder folder;
  std::string text = walk(5);
  text.resize(text.size() - 100);
  const Imported result = imported(folder, "node-kinect2", {text_file(folder, "a.json", text)});
  EXPECT_EQ(result.session.counts(0).body_frames, 4u);
  EXPECT_EQ(result.report.sensors[0].left_out.torn_rows, 1);
  EXPECT_THAT(result.report.sensors[0].left_out.first, HasSubstr("a.json:1 (byte "));
}

TEST(NodeKinect2Import, AnElementThatIsNoBodyCostsOnlyItself) {
  const ScratchFolder folder;
  const auto file =
      text_file(folder, "a.json", "[" + element(0, 0) + R"(,{"joints":"]}"},)" + element(1, 33) + "]");
  const Imported result = imported(folder, "node-kinect2", {file});
  EXPECT_EQ(result.session.counts(0).body_frames, 2u);
  EXPECT_EQ(result.report.sensors[0].left_out.torn_rows, 1);
}

std::string without_start(std::string text) {
  const std::string start = R"("record_startime":1518026639637,)";
  for (std::size_t at; (at = text.find(start)) != std::string::npos;) text.erase(at, start.size());
  return text;
}

TEST(NodeKinect2Import, AFileThatDoesNotSayWhenItBeganIsReadAndTheNoteSaysSo) {
  const ScratchFolder folder;
  const auto file =
      text_file(folder, "a.json", without_start("[" + element(0, 11) + "," + element(1, 44) + "]"));
  const Imported result = imported(folder, "node-kinect2", {file});
  const auto frames = result.frames();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].stamp.arrival_ns, 11'000'000);
  EXPECT_EQ(result.session.header().started_utc, "");
  EXPECT_THAT(result.session.header().note, HasSubstr("does not say when it began"));
  EXPECT_EQ(result.report.sensors[0].left_out.torn_rows, 0);
  const auto other = text_file(folder, "b.json", walk(3));
  EXPECT_THAT(import_refusal(folder, "node-kinect2", {other, file}),
              AllOf(HasSubstr("a.json"), HasSubstr("shares no clock")));
}

TEST(NodeKinect2Import, RefusesOtherFiles) {
  const ScratchFolder folder;
  const auto refusal = [&](const std::string& text) {
    return import_refusal(folder, "node-kinect2", {text_file(folder, "a.json", text)});
  };
  EXPECT_THAT(refusal(""), HasSubstr("does not begin with '['"));
  EXPECT_THAT(refusal("{}"), HasSubstr("does not begin with '['"));
  EXPECT_THAT(refusal("[]"), HasSubstr("no frame"));
  EXPECT_THAT(refusal("[1, 2]"), HasSubstr("no object"));
  EXPECT_THAT(refusal("[{}]"), HasSubstr("record_timestamp"));
}

TEST(NodeKinect2Import, TakesEveryFrameOfTheRealFile) {
  const auto path = shared_recordings() / "kinectron-node-kinect2" / "recorded_skeleton.json";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path.string() << " is not there";
  const ScratchFolder folder;
  const Imported result = imported(folder, "node-kinect2", {path});
  EXPECT_EQ(result.session.counts(0).body_frames, 286u);
  EXPECT_EQ(result.session.counts(0).bodies, 286u);
  EXPECT_EQ(result.report.sensors[0].left_out.total(), 0);
  EXPECT_EQ(result.frames()[0].bodies[0].tracking_id, 72057594037928243u);
  ASSERT_TRUE(result.report.sensors[0].intrinsics_rms_px.has_value());
  EXPECT_LT(*result.report.sensors[0].intrinsics_rms_px, 0.3);
  EXPECT_NEAR(result.session.header().sensors[0].intrinsics.fx_px, 366.0, 3.0);
}

}  // namespace
}  // namespace trilat
