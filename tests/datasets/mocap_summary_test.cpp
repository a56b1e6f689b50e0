// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_summary.h"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/mocap/mocap_reader.h"
#include "tests/datasets/temporary_file.h"

namespace trilat {
namespace {

constexpr double kRate_hz = 100.0;

MocapHeader one_body() {
  MocapHeader header;
  header.export_rate_hz = kRate_hz;
  header.assets.push_back(
      {.type = AssetType::rigid_body, .name = "b", .id = "1", .parent = {}, .has_position = true});
  return header;
}

MocapPose pose_at(double x_m) {
  MocapPose pose;
  pose.position_m = {x_m, 1.0, 2.0};
  return pose;
}

MocapFrame frame_of(std::int64_t index, const MocapPose& pose) {
  MocapFrame frame;
  frame.index = index;
  frame.time = {index * 10'000'000};
  frame.printed_time_s = static_cast<double>(index) / kRate_hz;
  frame.poses = {pose};
  return frame;
}

AssetSummary asset_summary(const std::vector<MocapPose>& poses, std::int64_t step = 1) {
  MocapSummarizer summarizer(one_body());
  std::int64_t index = -step;
  for (const MocapPose& pose : poses) summarizer.add(frame_of(index += step, pose));
  return summarizer.finish().assets.at(0);
}

std::vector<MocapPose> moving(int count, double from_m = 0.0) {
  std::vector<MocapPose> poses;
  for (int i = 0; i < count; ++i) poses.push_back(pose_at(from_m + 1e-6 * i));
  return poses;
}

void append(std::vector<MocapPose>& poses, int count, const MocapPose& pose) {
  poses.insert(poses.end(), static_cast<std::size_t>(count), pose);
}

TEST(MocapSummary, CountsFramesGapsRateAndTimeError) {
  MocapSummarizer summarizer(one_body());
  for (const std::int64_t index : {10, 11, 15, 16, 20}) {
    MocapFrame frame = frame_of(index, pose_at(1e-6 * static_cast<double>(index)));
    frame.time = {(index - 10) * 10'000'000};
    if (index == 16) frame.printed_time_s += 0.0004;
    summarizer.add(frame);
  }
  const MocapSummary summary = summarizer.finish();
  EXPECT_EQ(summary.frames, 5);
  EXPECT_EQ(summary.index_gaps, 2);
  EXPECT_EQ(summary.skipped_frames, 6);
  EXPECT_DOUBLE_EQ(summary.duration_s, 0.1);
  EXPECT_EQ(summary.rate_hz, kRate_hz);
  EXPECT_NEAR(summary.largest_time_error_s, 0.0004, 1e-12);
  EXPECT_NEAR(summary.assets.at(0).longest_gap_s, 0.04, 1e-12);
}

TEST(MocapSummary, OfNothingIsEmptyNotWrong) {
  const MocapSummary summary = MocapSummarizer(one_body()).finish();
  EXPECT_EQ(summary.frames, 0);
  EXPECT_EQ(summary.duration_s, 0.0);
  EXPECT_TRUE(std::isnan(summary.largest_time_error_s));
  EXPECT_EQ(summary.assets.at(0).samples, 0);
}

TEST(MocapSummary, MeasuresTheRateWhenNoneIsStated) {
  MocapHeader header = one_body();
  header.export_rate_hz = kMissing;
  MocapSummarizer summarizer(header);
  summarizer.add(frame_of(0, pose_at(0)));
  EXPECT_TRUE(std::isnan(summarizer.finish().rate_hz));
  summarizer.add(frame_of(1, pose_at(1e-6)));
  summarizer.add(frame_of(2, pose_at(2e-6)));
  EXPECT_NEAR(summarizer.finish().rate_hz, 100.0, 1e-9);
}

TEST(MocapSummary, SeparatesSamplesFromMissing) {
  std::vector<MocapPose> poses = moving(3);
  append(poses, 4, MocapPose());
  poses.push_back(pose_at(1e-5));
  append(poses, 9, MocapPose());
  const AssetSummary summary = asset_summary(poses);
  EXPECT_EQ(summary.samples, 4);
  EXPECT_EQ(summary.missing, 13);
  EXPECT_DOUBLE_EQ(summary.longest_gap_s, 0.05);  // the missing tail is no gap
}

TEST(MocapSummary, FrozenIsAStretchOfATenthOfASecondToTheBit) {
  std::vector<MocapPose> poses = moving(3);
  append(poses, 11, pose_at(0.5));
  EXPECT_EQ(asset_summary(poses).frozen, 11);
  append(poses, 4, pose_at(0.5));
  EXPECT_EQ(asset_summary(poses).frozen, 15);
  poses = moving(3);
  append(poses, 10, pose_at(0.5));  // spans 0.09 s
  EXPECT_EQ(asset_summary(poses).frozen, 0);
}

TEST(MocapSummary, FrozenTakesFiveFramesAtALowRate) {
  constexpr std::int64_t kAtTwentyFiveHertz = 4;
  std::vector<MocapPose> poses = moving(2);
  append(poses, 4, pose_at(0.5));
  EXPECT_EQ(asset_summary(poses, kAtTwentyFiveHertz).frozen, 0);
  append(poses, 1, pose_at(0.5));
  EXPECT_EQ(asset_summary(poses, kAtTwentyFiveHertz).frozen, 5);
}

TEST(MocapSummary, AStillBodyWithNoiseInTheLastDigitIsNotFrozen) {
  std::vector<MocapPose> poses;
  for (int i = 0; i < 100; ++i) poses.push_back(pose_at(0.5 + (i % 2) * 1e-6));
  EXPECT_EQ(asset_summary(poses).frozen, 0);
}

TEST(MocapSummary, ABodyThatHasNotMovedIsNotFrozen) {
  std::vector<MocapPose> poses;
  append(poses, 50, pose_at(0.5));
  EXPECT_EQ(asset_summary(poses).frozen, 0);
}

TEST(MocapSummary, AMissingFrameEndsAFrozenStretch) {
  std::vector<MocapPose> poses = moving(3);
  append(poses, 8, pose_at(0.5));
  append(poses, 1, MocapPose());
  append(poses, 8, pose_at(0.5));
  EXPECT_EQ(asset_summary(poses).frozen, 0);
}

TEST(MocapSummary, JumpsAreStepsFasterThanTheLimit) {
  // 0.19 m and 0.21 m in 10 ms are 19 and 21 m/s.
  EXPECT_EQ(asset_summary({pose_at(0), pose_at(0.19), pose_at(0.40), pose_at(0.40)}).jumps, 1);
  EXPECT_EQ(asset_summary({pose_at(0), MocapPose(), pose_at(0.39)}).jumps, 0);
}

// An asset "a" of this type, and a marker "b" that moves by `step_mm` a frame.
template <class Number>
std::string take_of(const std::vector<Number>& x_mm, const std::string& type = "Rigid Body",
                    double step_mm = 0.001) {
  std::string text = "Format Version,1.23,Export Frame Rate,100,Length Units,Millimeters\n\n,Type," + type +
                     "," + type + "," + type +
                     ",Marker,Marker,Marker\n,Name,a,a,a,b,b,b\n,ID,1,1,1,2,2,2\n,,Position,Position,"
                     "Position,Position,Position,Position\nFrame,Time (Seconds),X,Y,Z,X,Y,Z\n";
  for (std::size_t i = 0; i < x_mm.size(); ++i)
    text += fmt::format("{},{:.2f},{},5,0,{:.3f},5,0\n", i, 0.01 * static_cast<double>(i), x_mm[i],
                        step_mm * static_cast<double>(i));
  return text;
}

std::vector<int> filtered(const std::vector<int>& x_mm) {
  const TemporaryFile file(take_of(x_mm));
  MocapReader reader(file.path());
  const MocapPositions positions = read_positions(reader, {0, 1});
  std::vector<int> result;
  for (const Eigen::Vector3d& position_m : positions.position_m[0])
    result.push_back(position_m.allFinite() ? static_cast<int>(std::lround(position_m.x() * 1e3)) : -1);
  EXPECT_EQ(positions.time.size(), x_mm.size());
  EXPECT_TRUE(std::ranges::all_of(positions.position_m[1], [](const auto& p) { return p.allFinite(); }));
  EXPECT_EQ(positions.removed.frozen, std::ranges::count(result, -1));
  return result;
}

TEST(Positions, OfAFrozenStretchAreMissingFromItsFirstFrameOn) {
  std::vector<int> moving{1, 2}, still(12, 7), expected{1, 2};
  moving.insert(moving.end(), still.begin(), still.end());
  moving.insert(moving.end(), {3, 4});
  expected.insert(expected.end(), still.size(), -1);
  expected.insert(expected.end(), {3, 4});
  EXPECT_EQ(filtered(moving), expected);
  EXPECT_EQ(filtered(still), still);  // it has not moved before
  EXPECT_EQ(filtered({1, 7, 7, 2, 8, 8}), (std::vector<int>{1, 7, 7, 2, 8, 8}));
  EXPECT_EQ(filtered({1}), (std::vector<int>{1}));
  EXPECT_EQ(filtered({}), (std::vector<int>{}));
}

TEST(Positions, ExactlyAtTheOriginAreMissing) {
  std::string text = take_of(std::vector<int>{1, 2, 3, 4});
  const auto row = text.find("\n2,") + 1;
  text.replace(row, text.find('\n', row) - row, "2,0.02,0,0,0,2,5,0");
  const TemporaryFile file(text);
  MocapReader reader(file.path());
  const MocapPositions positions = read_positions(reader, {0});
  std::vector<bool> present;
  for (const Eigen::Vector3d& position_m : positions.position_m[0]) present.push_back(position_m.allFinite());
  EXPECT_EQ(present, (std::vector<bool>{true, true, false, true}));
  EXPECT_EQ(positions.removed.at_origin, 1);
  EXPECT_EQ(positions.removed.frozen, 0);
}

TEST(Positions, AreReadAsFarAsIsAskedFor) {
  const TemporaryFile file(take_of(std::vector<int>{1, 2, 3, 4, 5}));
  MocapReader reader(file.path());
  const MocapPositions positions = read_positions(reader, {1}, MocapTime{20'000'000});
  EXPECT_EQ(positions.time.size(), 3u);  // one frame in 10 ms
  EXPECT_TRUE(positions.position_m[0].empty());
  EXPECT_EQ(positions.position_m[1].size(), 3u);
}

// Rest of a still asset: noise of 0.02 mm that is smoothed over 20 frames (AR(1), 0.95), written in such
// steps.
std::vector<double> resting_mm(double step_mm) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, 0.02 * std::sqrt(1.0 - 0.95 * 0.95));
  std::vector<double> x_mm;
  for (double noise_mm = 0.0; x_mm.size() < 2000;) {
    const double moved_mm =
        x_mm.size() < 50 ? 20.0 * static_cast<double>(x_mm.size()) : 1000.0;  // then it rests
    noise_mm = 0.95 * noise_mm + normal(random);
    x_mm.push_back(step_mm * std::round((moved_mm + noise_mm) / step_mm));
  }
  return x_mm;
}

std::int64_t frozen_in(const std::string& text) {
  const TemporaryFile file(text);
  MocapReader reader(file.path());
  return read_positions(reader, {0, 1}).removed.frozen;
}

TEST(Positions, OfWhatRestsInACoarseFileStay) {
  for (const double step_mm : {0.1, 1.0})
    for (const char* type : {"Marker", "Rigid Body", "Bone"})
      EXPECT_EQ(frozen_in(take_of(resting_mm(step_mm), type, step_mm)), 0)
          << type << " in steps of " << step_mm;
}

TEST(Positions, OfAMarkerThatStandsStillToTheLastDigitStay) {
  std::vector<double> x_mm(50, 3.0);
  for (int i = 0; i < 10; ++i) x_mm[static_cast<std::size_t>(i)] = i;
  EXPECT_EQ(frozen_in(take_of(x_mm, "Marker")), 0);
  EXPECT_EQ(frozen_in(take_of(x_mm, "Rigid Body")), 40);
}

TEST(Positions, AsManyAreFrozenAsTheSummaryCounts) {
  std::vector<int> x_mm;
  for (int i = 0; i < 400; ++i) x_mm.push_back(i % 37 < 20 ? i / 37 : i);
  const auto result = filtered(x_mm);
  const auto frozen = std::ranges::count(result, -1);
  const TemporaryFile file(take_of(x_mm));
  MocapReader reader(file.path());
  EXPECT_EQ(summarize_mocap(reader).assets.at(0).frozen, frozen);
  EXPECT_GT(frozen, 100);
  EXPECT_LT(frozen, 300);
}

}  // namespace
}  // namespace trilat
