// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/mocap/mocap_writer.h"
#include "datasets/mocap/read_mocap.h"
#include "tests/support/scratch.h"
#include "tests/support/whole_take.h"

namespace trilat {
namespace {

using testing::HasSubstr;

const double kNan = std::nan("");

// Two joints on curves; the second is missing in every third frame.
JointFrame joint_frame(std::int64_t i) {
  const double t = 0.04 * static_cast<double>(i);
  JointFrame frame{
      .time_s = t,
      .position_m = {{std::sin(t), 1.0 + 0.1234567 * std::min(t, 1.0), -2.5}, {0.25, -std::cos(t), 3.0}},
      .sigma_m = {0.0123, 0.4},
      .status = {"estimated", "estimated"}};
  if (i % 3 == 2) {
    frame.position_m[1].setConstant(kNan);
    frame.status[1] = "too_few";
  }
  return frame;
}

JointTrack track_of(std::int64_t frames) {
  return {{"Head", "HandLeft"}, 25.0, frames, [i = std::int64_t{0}](JointFrame& frame) mutable {
            frame = joint_frame(i++);
          }};
}

void expect_read_back(const std::filesystem::path& path, std::int64_t frames, double within_m) {
  const WholeTake take = whole_take(path);
  EXPECT_EQ(take.header.length_unit, LengthUnit::millimetre);
  EXPECT_EQ(take.header.export_rate_hz, 25.0);
  ASSERT_EQ(take.header.assets.size(), 2u);
  EXPECT_EQ(take.header.assets[1].name, "HandLeft");
  ASSERT_EQ(std::ssize(take.frames), frames);
  for (std::int64_t i = 0; i < frames; ++i) {
    const WholeTake::Frame& read = take.frames[static_cast<std::size_t>(i)];
    const JointFrame written = joint_frame(i);
    ASSERT_EQ(read.time, MocapTime{40'000'000 * i});
    ASSERT_EQ(read.index, i + 1);
    ASSERT_LT((read.poses[0].position_m - written.position_m[0]).cwiseAbs().maxCoeff(), within_m);
    ASSERT_EQ(read.poses[1].has_position(), i % 3 != 2);
    if (i % 3 != 2) {
      ASSERT_LT((read.poses[1].position_m - written.position_m[1]).cwiseAbs().maxCoeff(), within_m);
    }
  }
  EXPECT_EQ(take.anomalies.rows_with_extra_fields + take.anomalies.printed_time_differs, 0);
}

TEST(JointFiles, ATrcComesBackToItsMicrometre) {
  const ScratchFolder folder;
  write_trc(folder / "walk.trc", track_of(100));
  expect_read_back(folder / "walk.trc", 100, 0.51e-6);
}

TEST(JointFiles, ATrcHasTheRowsThatOpenSimReads) {
  const ScratchFolder folder;
  write_trc(folder / "walk.trc", track_of(3));
  EXPECT_EQ(
      read_file(folder / "walk.trc"),
      "PathFileType\t4\t(X/Y/Z)\twalk.trc\n"
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
      "25\t25\t3\t2\tmm\t25\t1\t3\n"
      "Frame#\tTime\tHead\t\t\tHandLeft\t\t\n"
      "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
      "1\t0.000000\t0.000\t1000.000\t-2500.000\t250.000\t-1000.000\t3000.000\n"
      "2\t0.040000\t39.989\t1004.938\t-2500.000\t250.000\t-999.200\t3000.000\n"
      "3\t0.080000\t79.915\t1009.877\t-2500.000\t\t\t\n");
}

TEST(JointFiles, ACsvHasARowAFrameAndJointWithBlanksForWhatIsMissing) {
  const ScratchFolder folder;
  JointTrack track = track_of(3);
  write_joint_csv(folder / "walk.csv", track);
  const std::string text = read_file(folder / "walk.csv");
  EXPECT_THAT(text, HasSubstr("frame,time_s,joint,status,x_m,y_m,z_m,sigma_m\n"
                              "1,0.000000,Head,estimated,0.000000,1.000000,-2.500000,0.012300\n"));
  EXPECT_THAT(text, HasSubstr("\n3,0.080000,HandLeft,too_few,,,,\n"));
  EXPECT_EQ(std::ranges::count(text, '\n'), 7);
}

TEST(JointFiles, WhatIsNotKnownOfAJointIsLeftOut) {
  const ScratchFolder folder;
  const JointTrack track{{"Head"}, 25.0, 1, [](JointFrame& frame) {
                           frame = {.time_s = 2.0, .position_m = {{1, 2, 3}}, .sigma_m = {}, .status = {}};
                         }};
  write_joint_csv(folder / "walk.csv", track);
  EXPECT_THAT(read_file(folder / "walk.csv"), HasSubstr("\n1,2.000000,Head,,1.000000,2.000000,3.000000,\n"));
}

TEST(JointFiles, FramesThatDoNotFollowEachOtherAtTheRateAreABug) {
  const ScratchFolder folder;
  const auto written = [&](double late) {
    JointTrack track = track_of(3);
    track.next = [late, i = std::int64_t{0}](JointFrame& frame) mutable {
      frame = joint_frame(i);
      if (i++ == 2) frame.time_s += 0.04 * late;
    };
    write_trc(folder / "joints.trc", track);
  };
  EXPECT_NO_THROW(written(0.45));
  for (const double late : {0.6, -0.6})
    EXPECT_THAT([&] { written(late); },
                testing::ThrowsMessage<InternalError>(HasSubstr("frames follow each other at the rate")));
}

// Notes of read_joint_csv() on a file that has one joint at each of these times.
std::vector<std::string> said_of_times(const std::vector<double>& times) {
  const ScratchFolder folder;
  std::string text = "time_s,joint,x_m,y_m,z_m\n";
  for (std::size_t i = 0; i < times.size(); ++i)
    text += fmt::format("{},head,{},1.5,2\n", times[i], 0.01 * static_cast<double>(i));
  write_file(folder / "mine.csv", text);
  return read_joint_csv(folder / "mine.csv").taken_as;
}

TEST(JointFiles, TimesThatStepByOneMayCountFrames) {
  EXPECT_THAT(said_of_times({0, 1, 2, 3}),
              testing::ElementsAre(HasSubstr("time_s counts by 1, as frame numbers do")));
  EXPECT_THAT(said_of_times({0, 1}), testing::IsEmpty());
  EXPECT_THAT(said_of_times({0.5, 1.5, 2.5, 3.5}), testing::IsEmpty()) << "frame numbers are whole";
  EXPECT_THAT(said_of_times({0, 2, 4}), testing::IsEmpty());
}

TEST(JointFiles, TimesOfCamerasAreReadInTheirUnit) {
  EXPECT_THAT(said_of_times({0, 40, 80, 120}),
              testing::ElementsAre(HasSubstr("taken as milliseconds, 25 Hz")));
  EXPECT_THAT(said_of_times({0, 1000, 2000}),
              testing::ElementsAre(HasSubstr("taken as microseconds, 1000 Hz")));
  EXPECT_THAT(said_of_times({0, 200, 400}), testing::ElementsAre(HasSubstr("taken as milliseconds, 5 Hz")));
  EXPECT_THAT(message_of([] { said_of_times({0, 300, 600}); }), HasSubstr("time_s steps by 300; in seconds"));
}

TEST(JointFiles, ATrackThatFailsLeavesNoFile) {
  const ScratchFolder folder;
  const JointTrack track{{"Head"}, 25.0, 1, [](JointFrame&) { throw InputError("x", "y"); }};
  for (const auto write : {write_trc, write_joint_csv})
    EXPECT_THROW(write(folder / "walk", track), InputError);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace trilat
