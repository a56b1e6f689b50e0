// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/calibration_numbers.h"

#include <cmath>

#include <gmock/gmock.h>

#include "pipeline/calibration_study/place_samples.h"

namespace trilat {
namespace {

// Columns without a depth count for nothing.
TEST(ColumnMeans, AreOverTheColumnsThatHadADepth) {
  std::vector<double> by_column(512, 0.02);
  std::fill(by_column.begin() + 150, by_column.begin() + 351, 0.01);
  by_column[0] = by_column[200] = by_column[511] = NAN;
  const ColumnMeans means = column_means(by_column);
  EXPECT_NEAR(means.left, 0.02, 1e-12);
  EXPECT_NEAR(means.middle, 0.01, 1e-12);
  EXPECT_NEAR(means.right, 0.02, 1e-12);
  EXPECT_NEAR(means.edge, 0.02, 1e-12);
}

// 1 to 5 mm: the mean is 3, the squares about it add up to 10; quantiles interpolate between neighbours.
TEST(ErrorStatistics, MeanDeviationAndQuantilesByPencil) {
  std::vector<ClusteredError> errors;
  for (std::size_t i : {4u, 0u, 2u, 1u, 3u}) errors.push_back({0, 1e-3 * static_cast<double>(i + 1)});
  errors.push_back({1, kNaN});
  const ErrorStatistics spread = statistics_of(errors);
  EXPECT_EQ(spread.asked, 6u);
  EXPECT_EQ(spread.answered, 5u);
  EXPECT_NEAR(spread.mean_m, 0.003, 1e-15);
  EXPECT_NEAR(spread.sd_m, std::sqrt(10e-6 / 4.0), 1e-15);
  EXPECT_NEAR(spread.median_m, 0.003, 1e-15);
  EXPECT_NEAR(spread.p95_m, 0.0048, 1e-15);
  EXPECT_NEAR(spread.max_m, 0.005, 1e-15);
  EXPECT_TRUE(std::isnan(spread.mean_low_m));
}

TEST(ErrorStatistics, NothingAndOneErrorHaveNoNumbersTheyCannotHave) {
  const ErrorStatistics nothing = statistics_of({}), none = statistics_of({{0, kNaN}});
  EXPECT_EQ(nothing.asked, 0u);
  EXPECT_EQ(none.asked, 1u);
  for (const ErrorStatistics& spread : {nothing, none}) {
    EXPECT_EQ(spread.answered, 0u);
    EXPECT_TRUE(std::isnan(spread.mean_m) && std::isnan(spread.sd_m) && std::isnan(spread.max_m));
  }
  const ErrorStatistics one = statistics_of({{0, 0.25}});
  EXPECT_EQ(one.mean_m, 0.25);
  EXPECT_EQ(one.p95_m, 0.25);
  EXPECT_TRUE(std::isnan(one.sd_m));
}

TEST(ErrorStatistics, AnIntervalIsBetweenClusters) {
  const auto clusters = [](std::size_t count) {
    std::vector<ClusteredError> errors;
    for (std::size_t c = 0; c < count; ++c)
      for (int i = 0; i < 100; ++i) errors.push_back({c, 1e-3 * static_cast<double>(c + 1)});
    return errors;
  };
  EXPECT_TRUE(std::isnan(statistics_of(clusters(1)).mean_low_m));
  // 1 to 4 mm: Student's t of three degrees, and a standard error of sqrt(5 / 3) / 2 mm
  const ErrorStatistics spread = statistics_of(clusters(4));
  EXPECT_NEAR(spread.mean_low_m, 0.0025 - 3.182446 * 0.001 * std::sqrt(5.0 / 3.0) / 2.0, 1e-8);
  EXPECT_NEAR(spread.mean_high_m, 0.0025 + 3.182446 * 0.001 * std::sqrt(5.0 / 3.0) / 2.0, 1e-8);
}

// Two sensors and four places: two within the paper's recommended range, one beyond, one too near, where one
// sensor has no answer and the other one takes another thing for the ball.
TEST(CalibrationNumbers, OfABallByPencil) {
  WandRecording wand;
  wand.name = "bench";
  wand.ball_radius_m = 0.1;
  wand.sensors = {"k1", "k2"};
  const std::size_t ours = wand_method("ours");
  wand.statuses.resize(wand_method_names().size());
  wand.statuses[ours] = {{"found", 7}, {"nothing", 1}};
  for (std::size_t sensor = 0; sensor < 2; ++sensor) {
    const double more_m = 0.01 * static_cast<double>(sensor);
    wand.samples.push_back({ours, sensor, 0, 1.0, 0.1, 0.01 + more_m, 0.02 + more_m});
    wand.samples.push_back({ours, sensor, 3, 3.5, 0.2, 0.05 + more_m, 0.06 + more_m});
    wand.samples.push_back({ours, sensor, 1, 3.0, 0.2, 0.03 + more_m, 0.04 + more_m});
    wand.samples.push_back({ours, sensor, 2, 0.4, 0.1, sensor == 1 ? 0.5 : kNaN, sensor == 1 ? 0.5 : kNaN});
  }
  wand.poses = {{"refined", "k1", 0.01, 0.02, 0.03, 0.04}, {"refined", "k2", 0.03, 0.02, 0.03, 0.04}};
  WallRow wall{"wall", "k1", 2.0, 2.01, 0.05, 7, 0.001, std::vector<double>(512, 0.02), {}};
  wall.residual_m[200] = 0.05;
  wall.printed_error_m = wall.residual_m;
  const Numbers numbers = calibration_numbers({{wand}, {wall}});
  const auto number = [&](const std::string& group, const char* measure, const char* statistic) {
    const Number* found = numbers.find(
        {.condition = "bench", .group = group, .method = "ours", .measure = measure, .statistic = statistic});
    EXPECT_TRUE(found) << group << measure << statistic;
    return found ? *found : Number{};
  };
  EXPECT_NEAR(number(kInside, "ball_distance", "mean").value, 0.025, 1e-15);
  EXPECT_EQ(number(kInside, "ball_distance", "mean").n, 4u);
  EXPECT_EQ(number(kInside, "ball_distance", "mean").clusters, 2u);
  EXPECT_NEAR(number(kInside, "ball_position", "mean").value, 0.035, 1e-15);
  EXPECT_EQ(number(kInside, "answered", "share").n, 4u);
  EXPECT_EQ(number(kAllPlaces, "answered", "share").value, 7.0 / 8.0);
  EXPECT_EQ(number(kNear, "answered", "share").value, 0.5);
  EXPECT_EQ(number(kNear, "ball_distance", "max").value, 0.5);
  EXPECT_EQ(number("distance below 0.5 m", "ball_distance", "mean").n, 1u);
  EXPECT_EQ(number("distance 3 to 3.75 m", "ball_distance", "mean").n, 4u);  // an edge is of the bin above
  EXPECT_EQ(number("angle 9 to 18 degrees", "ball_distance", "mean").n, 4u);
  EXPECT_EQ(numbers.n({.condition = "bench",
                       .group = "farther",
                       .method = "ours",
                       .against = "inside",
                       .measure = "ball_distance",
                       .statistic = "relative_difference"}),
            2u);
  EXPECT_NEAR(numbers.value({.condition = "bench",
                             .group = "farther",
                             .method = "ours",
                             .against = "inside",
                             .measure = "ball_distance",
                             .statistic = "relative_difference"}),
              0.055 / 0.025 - 1.0, 1e-12);
  EXPECT_EQ(number(kAllPlaces, "status", "another_thing").n, 1u);
  EXPECT_EQ(number(kAllPlaces, "status", "found").value, 7.0 / 8.0);
  const auto pose = [&](const char* sensor, const char* measure, const char* statistic) {
    return numbers.value({.condition = "bench",
                          .group = sensor,
                          .method = "refined",
                          .measure = measure,
                          .statistic = statistic});
  };
  EXPECT_EQ(pose("k2", "pose", "difference"), 0.03);
  EXPECT_EQ(pose("k1", "rotation", "difference"), 0.02);
  EXPECT_EQ(pose("k1", "pose", "sigma"), 0.03);
  EXPECT_EQ(pose("k1", "rotation", "sigma"), 0.04);
  EXPECT_EQ(numbers.value({.method = "refined", .measure = "pose", .statistic = "mean_difference"}), 0.02);
  const auto of_wall = [&](const char* measure, const char* statistic) {
    return numbers.value({.condition = "wall", .group = "k1", .measure = measure, .statistic = statistic});
  };
  EXPECT_EQ(of_wall("wall", "distance"), 2.01);
  EXPECT_EQ(of_wall("wall", "stated"), 2.0);
  EXPECT_EQ(of_wall("wall", "noise"), 0.001);
  EXPECT_EQ(of_wall("tilt", "mean"), 0.05);
  EXPECT_EQ(of_wall("residual", "max"), 0.05);
  EXPECT_NEAR(of_wall("residual", "middle"), (200 * 0.02 + 0.05) / 201, 1e-12);
  EXPECT_NEAR(of_wall("sideways", "edge"), 0.02, 1e-12);
}

}  // namespace
}  // namespace trilat
