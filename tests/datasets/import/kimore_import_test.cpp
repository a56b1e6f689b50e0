// SPDX-License-Identifier: MIT
// Files of our own in the layout that programs which read the data set expect.
#include <gmock/gmock.h>

#include "tests/datasets/import/import_fixtures.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string positions(int frame) {
  std::string text;
  for (int j = 0; j < kJointCount; ++j) {
    const auto p = made_up_joint_m(frame, j);
    text += fmt::format("{},{},{},{},", p[0], p[1], p[2], j == 0 ? 1 : 2);
  }
  return text + "\n";
}

std::string orientations() {
  std::string text;
  for (int j = 0; j < kJointCount; ++j) text += "0.1,0.2,0.3,0.9,";
  return text + "\n";
}

struct Exercise {
  ScratchFolder folder;
  std::filesystem::path raw = folder / "Raw";
  Exercise() {
    std::filesystem::create_directory(raw);
    write("JointPosition1.csv", "\n" + positions(0) + positions(1) + positions(2));
    write("JointOrientation1.csv", "\n" + orientations() + orientations() + orientations());
    write("TimeStamp1.csv", "\n1000\n334333,\n667666\n");
  }
  void write(const std::string& name, const std::string& text) const { write_file(raw / name, text); }
};

TEST(KimoreImport, PutsTheRowsOfTheThreeFilesTogether) {
  const Exercise exercise;
  const Imported result = imported(exercise.folder, "kimore", {exercise.raw});
  const auto frames = result.frames();
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[1].stamp.device_ticks, 334'333);
  EXPECT_THAT(sequences(frames), ElementsAre(0, 1, 2));
  const Body& body = frames[1].bodies.at(0);
  EXPECT_EQ(body.position_m[4][0], static_cast<float>(made_up_joint_m(1, 4)[0]));
  EXPECT_THAT(body.orientation_xyzw[24], ElementsAre(0.1f, 0.2f, 0.3f, 0.9f));
  EXPECT_EQ(body.tracking_state[0], 1);
  EXPECT_EQ(body.tracking_state[1], 2);
  EXPECT_THAT(result.report.note, HasSubstr("not yet been run on a real file"));
}

TEST(KimoreImport, DoesWithoutOrientations) {
  const Exercise exercise;
  std::filesystem::remove(exercise.raw / "JointOrientation1.csv");
  const auto frames = imported(exercise.folder, "kimore", {exercise.raw}).frames();
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_THAT(frames[0].bodies[0].orientation_xyzw[3], ElementsAre(0.0f, 0.0f, 0.0f, 0.0f));
}

TEST(KimoreImport, PositionsAloneAreTakenWithARate) {
  const Exercise exercise;
  exercise.write("JointPosition1.csv", "\n" + positions(0) + "0.1,0.2,\n" + positions(2));
  const auto alone = exercise.raw / "JointPosition1.csv";
  EXPECT_THAT(import_refusal(exercise.folder, "kimore", {alone}), HasSubstr("--rate-hz: is missing"));
  const Imported result = imported(exercise.folder, "kimore", {alone}, {.rate_hz = 20.0});
  const auto frames = result.frames();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].stamp.device_ticks, 1'000'000);  // the torn row in between has its time
  EXPECT_EQ(frames[1].bodies[0].position_m[4][0], static_cast<float>(made_up_joint_m(2, 4)[0]));
  EXPECT_EQ(result.session.header().sensors[0].nominal_rate_hz, 20.0);
  EXPECT_THAT(result.report.note, HasSubstr("no time stamps: row / 20 Hz is the time"));
  EXPECT_THAT(result.report.note, HasSubstr("no orientations"));
  EXPECT_THAT(import_refusal(exercise.folder, "kimore", {exercise.raw}, {.rate_hz = 20.0}),
              HasSubstr("--rate-hz: is not for this format"));
}

TEST(KimoreImport, ATornRowCostsOneFrameAndShiftsNoOther) {
  const Exercise exercise;
  exercise.write("JointPosition1.csv", "\n" + positions(0) + "0.1,0.2,\n" + positions(2));
  const Imported result = imported(exercise.folder, "kimore", {exercise.raw});
  const auto frames = result.frames();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].stamp.device_ticks, 667'666);
  EXPECT_EQ(result.report.sensors[0].left_out.torn_rows, 1);
}

TEST(KimoreImport, CountsTheRowsThatOnlySomeFilesHave) {
  const Exercise exercise;
  exercise.write("TimeStamp1.csv", "\n1000\n334333\n");
  const Imported result = imported(exercise.folder, "kimore", {exercise.raw});
  EXPECT_EQ(result.session.counts(0).body_frames, 2u);
  EXPECT_EQ(result.report.sensors[0].left_out.torn_rows, 1);
}

TEST(KimoreImport, RefusesFoldersWithoutOrWithTwoExercises) {
  const Exercise exercise;
  exercise.write("TimeStamp2.csv", "1\n");
  EXPECT_THAT(import_refusal(exercise.folder, "kimore", {exercise.raw}), HasSubstr("2 files TimeStamp*.csv"));
  std::filesystem::remove(exercise.raw / "JointPosition1.csv");
  EXPECT_THAT(import_refusal(exercise.folder, "kimore", {exercise.raw}),
              HasSubstr("0 files JointPosition*.csv"));
}

}  // namespace
}  // namespace trilat
