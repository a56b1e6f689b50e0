// SPDX-License-Identifier: MIT
#include <cmath>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/mocap/mocap_take.h"
#include "datasets/mocap/read_mocap.h"
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

using Positions = std::vector<Eigen::Vector3d>;
const Eigen::Vector3d kNowhere = Eigen::Vector3d::Constant(kNaN);

Eigen::Vector3d at(double x_m) { return {x_m, 1.0, 2.0}; }

// One body over the frames of these numbers, at 100 Hz.
MocapTake take_at(const std::vector<std::int64_t>& frames, Positions position_m) {
  MocapTake take;
  take.header = one_body();
  take.frame = frames;
  for (const std::int64_t frame : frames) take.time.push_back({(frame - frames.front()) * 10'000'000});
  take.position_m = {std::move(position_m)};
  return take;
}

AssetSummary asset_summary(const Positions& position_m) {
  std::vector<std::int64_t> frames(position_m.size());
  std::iota(frames.begin(), frames.end(), std::int64_t{0});
  return summarize_mocap(take_at(frames, position_m)).assets.at(0);
}

Positions moving(int count) {
  Positions position_m;
  for (int i = 0; i < count; ++i) position_m.push_back(at(1e-6 * i));
  return position_m;
}

void append(Positions& position_m, int count, const Eigen::Vector3d& position) {
  position_m.insert(position_m.end(), static_cast<std::size_t>(count), position);
}

TEST(MocapSummary, CountsFramesGapsInTheirNumbersAndRate) {
  const MocapSummary summary = summarize_mocap(take_at({10, 11, 15, 16, 20}, moving(5)));
  EXPECT_EQ(summary.frames, 5);
  EXPECT_EQ(summary.index_gaps, 2);
  EXPECT_EQ(summary.skipped_frames, 6);
  EXPECT_DOUBLE_EQ(summary.duration_s, 0.1);
  EXPECT_EQ(summary.rate_hz, kRate_hz);
}

TEST(MocapSummary, OfNothingIsEmptyNotWrong) {
  const MocapSummary summary = summarize_mocap(take_at({}, {}));
  EXPECT_EQ(summary.frames, 0);
  EXPECT_EQ(summary.duration_s, 0.0);
  EXPECT_EQ(summary.assets.at(0).samples, 0);
}

TEST(MocapSummary, MeasuresTheRateWhenNoneIsStated) {
  MocapTake one = take_at({0}, moving(1)), three = take_at({0, 1, 2}, moving(3));
  one.header.export_rate_hz = three.header.export_rate_hz = kNaN;
  EXPECT_TRUE(std::isnan(summarize_mocap(one).rate_hz));
  EXPECT_NEAR(summarize_mocap(three).rate_hz, 100.0, 1e-9);
}

// An asset that is seen for half of a walk stands where it is about the others, not where the walk was then.
TEST(MocapSummary, SpreadsAssetsAboutTheirMiddleInEachFrame) {
  MocapTake take = take_at({0, 1, 2, 3}, {});
  take.header.assets.push_back(take.header.assets[0]);
  take.position_m = {{at(0.0), at(2.0), at(4.0), at(6.0)}, {at(0.0), at(2.0), kNowhere, kNowhere}};
  for (int frame : {0, 1}) take.position_m[1][static_cast<std::size_t>(frame)].y() += 1.0;
  const LikelyUp up = likely_up(summarize_mocap(take));
  EXPECT_TRUE(up.spread_m.isApprox(Eigen::Vector3d(0.0, 0.75, 0.0))) << up.spread_m.transpose();
  EXPECT_EQ(up.axis, 'y');
}

TEST(MocapSummary, SeparatesSamplesFromMissing) {
  Positions position_m = moving(3);
  append(position_m, 4, kNowhere);
  position_m.push_back(at(1e-5));
  append(position_m, 9, kNowhere);
  const AssetSummary summary = asset_summary(position_m);
  EXPECT_EQ(summary.samples, 4);
  EXPECT_EQ(summary.missing, 13);
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
  const MocapTake positions = read_positions(file.path());
  const MissingCounts counts = positions.missing.at(0);
  EXPECT_EQ(counts.sum(),
            std::ranges::count_if(positions.position_m[0], [](const auto& p) { return !p.allFinite(); }));
  for (std::size_t i = 1; i < positions.missing.size(); ++i) EXPECT_EQ(positions.missing[i].sum(), 0) << i;
  EXPECT_EQ(summarize_mocap(read_mocap(file.path())).assets.at(0).no_measurement.held, counts.held);
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
  for (const MissingCounts& counts : read_positions(file.path()).missing) EXPECT_EQ(counts.held, 0);
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

// It left by less than 1 cm, or by less than five of its usual steps: so a person moves on.
TEST(Missing, InACoarseFileASmallStepEndsNoHeldStretch) {
  std::vector<double> turning = swinging_mm(kFrames, 1), resting(kFrames, 500.0),
                      other = swinging_mm(kFrames, 2);
  hold(turning, 126, 152);  // about where it turns: 24 mm on, of steps of 7 mm
  for (std::size_t i = 200; i < kFrames; ++i) resting[i] = 505.0;
  for (double& x : other) x = 5.0 * std::round(x / 5.0);
  EXPECT_EQ(missing_of_first(take_of({{"a", turning}, {"b", other}}, "Marker", 0)).held, 0);
  EXPECT_EQ(missing_of_first(take_of({{"a", resting}, {"b", other}}, "Marker", 0)).held, 0);
  for (std::size_t i = 200; i < kFrames; ++i) resting[i] = 515.0;
  EXPECT_GT(missing_of_first(take_of({{"a", resting}, {"b", other}}, "Marker", 0)).held, 100);
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
    EXPECT_THAT([&] { read_positions(file.path()); },
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
  const MocapTake positions = read_positions(file.path(), {.assets = {{1}}, .until = {20'000'000}});
  EXPECT_EQ(positions.time.size(), 3u);  // one frame in 10 ms
  EXPECT_TRUE(positions.position_m[0].empty());
  EXPECT_EQ(positions.position_m[1].size(), 3u);
}

}  // namespace
}  // namespace trilat
