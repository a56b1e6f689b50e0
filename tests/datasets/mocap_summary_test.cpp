// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_summary.h"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/mocap/mocap_reader.h"
#include "tests/datasets/temporary_file.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

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

TEST(MocapSummary, JumpsAreStepsFasterThanTheLimit) {
  // 0.19 m and 0.21 m in 10 ms are 19 and 21 m/s.
  EXPECT_EQ(asset_summary({pose_at(0), pose_at(0.19), pose_at(0.40), pose_at(0.40)}).jumps, 1);
  EXPECT_EQ(asset_summary({pose_at(0), MocapPose(), pose_at(0.39)}).jumps, 0);
}

// Assets by name, each with its x in millimetres over time at 100 Hz, as Motive writes them in steps of a
// micrometre; y is 5 mm, z is 0. No number is a missing position.
std::string take_of(const std::vector<std::pair<std::string, std::vector<double>>>& assets,
                    const std::string& type = "Marker", int digits = 3) {
  std::string type_row = ",Type", name_row = ",Name", id_row = ",ID", what = ",",
              axes = "Frame,Time (Seconds)";
  for (std::size_t a = 0; a < assets.size(); ++a)
    for (const char* axis : {"X", "Y", "Z"}) {
      type_row += "," + type;
      name_row += "," + assets[a].first;
      id_row += fmt::format(",{}", a + 1);
      what += ",Position";
      axes += std::string(",") + axis;
    }
  std::string text = "Format Version,1.23,Export Frame Rate,100,Length Units,Millimeters\n\n" + type_row +
                     "\n" + name_row + "\n" + id_row + "\n" + what + "\n" + axes + "\n";
  for (std::size_t i = 0; i < assets.at(0).second.size(); ++i) {
    text += fmt::format("{},{:.2f}", i, 0.01 * static_cast<double>(i));
    for (const auto& [name, x_mm] : assets)
      text +=
          std::isnan(x_mm[i]) ? ",,," : fmt::format(",{:.{}f},{},0", x_mm[i], digits, x_mm[i] == 0.0 ? 0 : 5);
    text += "\n";
  }
  return text;
}

// Someone who moves: noise of 0.1 mm over a swing of 20 cm.
std::vector<double> swinging_mm(std::size_t frames, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 0.1);
  std::vector<double> x_mm;
  for (std::size_t i = 0; i < frames; ++i)
    x_mm.push_back(500.0 + 200.0 * std::sin(0.05 * static_cast<double>(i) + seed) + normal(random));
  return x_mm;
}

void hold(std::vector<double>& x_mm, std::size_t first, std::size_t end) {
  std::fill(x_mm.begin() + static_cast<std::ptrdiff_t>(first),
            x_mm.begin() + static_cast<std::ptrdiff_t>(end), x_mm[first]);
}

MissingCounts missing_of_first(const std::string& text) {
  const TemporaryFile file(text);
  MocapReader reader(file.path());
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < reader.header().assets.size(); ++i) all.push_back(i);
  const MocapPositions positions = read_positions(reader, all);
  const MissingCounts counts = positions.missing.at(0);
  EXPECT_EQ(counts.sum(),
            std::ranges::count_if(positions.position_m[0], [](const auto& p) { return !p.allFinite(); }));
  for (std::size_t i = 1; i < positions.missing.size(); ++i) EXPECT_EQ(positions.missing[i].sum(), 0) << i;
  MocapReader again(file.path());
  EXPECT_EQ(summarize_mocap(again).assets.at(0).no_measurement.held, counts.held);
  return counts;
}

constexpr std::size_t kFrames = 400;

TEST(Missing, AHeldPositionIsNoMeasurementButItsFirst) {
  for (const char* type : {"Marker", "Rigid Body", "Bone"})
    for (const auto& [first, end] : {std::pair{100u, 150u}, std::pair{0u, 30u}, std::pair{350u, 400u}}) {
      std::vector<double> held = swinging_mm(kFrames, 1);
      hold(held, first, end);
      EXPECT_EQ(
          missing_of_first(
              take_of({{"a", held}, {"b", swinging_mm(kFrames, 2)}, {"c", swinging_mm(kFrames, 3)}}, type))
              .held,
          end - first - 1)
          << type << first;
    }
}

TEST(Missing, AStretchBelowAFifthOfASecondIsLeft) {
  std::vector<double> held = swinging_mm(kFrames, 1);
  hold(held, 100, 120);  // 0.19 s
  EXPECT_EQ(missing_of_first(take_of({{"a", held}, {"b", swinging_mm(kFrames, 2)}})).held, 0);
}

TEST(Missing, WhoStandsStillWithAllJointsIsNotHeld) {
  std::vector<double> one = swinging_mm(kFrames, 1), two = swinging_mm(kFrames, 2);
  hold(one, 100, 200);
  hold(two, 95, 205);
  const TemporaryFile file(take_of({{"a", one}, {"b", two}}));
  MocapReader reader(file.path());
  for (const MissingCounts& counts : read_positions(reader, {0, 1}).missing) EXPECT_EQ(counts.held, 0);
}

// In whole millimetres what rests repeats: only a value that it then leaves with a jump was held.
TEST(Missing, InACoarseFileWhatRestsIsLeftAndWhatJumpsWasHeld) {
  std::vector<double> rests = swinging_mm(kFrames, 1), held = rests, other = swinging_mm(kFrames, 2);
  for (std::size_t i = 100; i < 160; ++i) rests[i] = rests[100] + 0.004 * static_cast<double>(i);
  for (std::size_t i = 160; i < kFrames; ++i) rests[i] = rests[159] + 1.5 * static_cast<double>(i - 159);
  hold(held, 100, 140);
  for (std::size_t i = 0; i < other.size(); ++i) other[i] = 5.0 * std::round(other[i] / 5.0);
  EXPECT_EQ(missing_of_first(take_of({{"a", rests}, {"b", other}}, "Marker", 0)).held, 0);
  EXPECT_EQ(missing_of_first(take_of({{"a", held}, {"b", other}}, "Marker", 0)).held, 39);
}

TEST(Missing, ARigidBodyAloneIsJudgedByItsOwnNoise) {
  std::vector<double> held = swinging_mm(kFrames, 1);
  hold(held, 100, 150);
  EXPECT_EQ(missing_of_first(take_of({{"a", held}}, "Rigid Body")).held, 49);
}

// Of so few steps nobody can tell whether the file has noise.
TEST(Missing, ARigidBodyAloneIsNotJudgedByAFewSteps) {
  std::vector<double> held = swinging_mm(45, 1);
  hold(held, 10, 32);
  EXPECT_EQ(missing_of_first(take_of({{"a", held}}, "Rigid Body")).held, 0);
}

TEST(Missing, TheOriginAndFarValuesThatRepeatAre) {
  for (const double fill_mm : {0.0, -16512.0, 9999.0, 1e6, 1e9}) {
    std::vector<double> filled = swinging_mm(kFrames, 1);
    for (std::size_t i = 7; i < kFrames; i += 20) filled[i] = fill_mm;
    const MissingCounts counts = missing_of_first(take_of({{"a", filled}, {"b", swinging_mm(kFrames, 2)}}));
    EXPECT_EQ(fill_mm == 0.0 ? counts.at_origin : counts.filled, 20) << fill_mm;
    EXPECT_EQ(counts.sum(), 20) << fill_mm;
  }
}

TEST(Missing, AThirdOfThePositionsMayBeFilled) {
  std::vector<double> one = swinging_mm(kFrames, 1);
  for (std::size_t i = 0; i < kFrames; ++i)
    if (i % 10 < 6) one[i] = 9999.0;
  EXPECT_EQ(missing_of_first(take_of({{"a", one}, {"b", swinging_mm(kFrames, 2)}})).filled, 240);
}

TEST(Missing, AFarValueThatComesOnceOrChangesIsRefused) {
  for (const std::vector<double>& far_mm : {std::vector{1e6}, std::vector{1e6, 2e6, 1e6}}) {
    std::vector<double> x_mm = swinging_mm(kFrames, 1);
    for (std::size_t k = 0; k < far_mm.size(); ++k) x_mm[10 * k + 5] = far_mm[k];
    const TemporaryFile file(take_of({{"a", x_mm}}));
    MocapReader reader(file.path());
    EXPECT_THAT([&] { read_positions(reader, {0}); },
                ThrowsMessage<InputError>(HasSubstr("is more than 100 m")));
  }
}

// A walk of twenty metres reaches far places, none twice.
TEST(Missing, AFarPlaceThatIsReachedIsLeft) {
  std::vector<double> walk;
  for (std::size_t i = 0; i < kFrames; ++i) walk.push_back(50.0 * static_cast<double>(i) + 1.0);
  EXPECT_EQ(missing_of_first(take_of({{"a", walk}, {"b", walk}})).sum(), 0);
}

TEST(Positions, AreReadAsFarAsIsAskedFor) {
  const TemporaryFile file(take_of({{"a", {1, 2, 3, 4, 5}}, {"b", {1, 2, 3, 4, 5}}}));
  MocapReader reader(file.path());
  const MocapPositions positions = read_positions(reader, {1}, MocapTime{20'000'000});
  EXPECT_EQ(positions.time.size(), 3u);  // one frame in 10 ms
  EXPECT_TRUE(positions.position_m[0].empty());
  EXPECT_EQ(positions.position_m[1].size(), 3u);
}

}  // namespace
}  // namespace trilat
