// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/calibration_numbers.h"

#include <cmath>

#include <gmock/gmock.h>

#include "pipeline/calibration_study/place_samples.h"
#include "tests/pipeline/table_rows.h"

namespace trilat {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

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
// sensor has no answer and the other one takes another thing for the ball. And a wall of 2 m.
CalibrationRecordings ball_and_wall() {
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
  return {{wand}, {wall}};
}

TEST(CalibrationNumbers, OfABallByPencil) {
  const Numbers numbers = calibration_numbers(ball_and_wall());
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

CalibrationSummary summary_of(const CalibrationRecordings& recordings) {
  CalibrationSummary summary;
  summary.study = "bench";
  summary.campaign = "lab";
  summary.numbers = calibration_numbers(recordings);
  return summary;
}

std::vector<std::string> rows_with(const Table& table, const std::string& text) {
  std::vector<std::string> rows = rows_of(table);
  std::erase_if(rows, [&](const std::string& row) { return row.find(text) == std::string::npos; });
  return rows;
}

TEST(CalibrationTables, PutThePaperBesideEveryWayToFindTheBall) {
  const CalibrationRecordings recordings = ball_and_wall();
  CalibrationSummary summary = summary_of(recordings);
  summary.failed = {"wall2: is no session"};
  StoredTables shown = calibration_tables(summary, recordings);
  EXPECT_EQ(shown.title, "bench on lab");
  EXPECT_EQ(shown.about, "Calibration by 1 recording of a ball and 1 wall, recorded.");
  EXPECT_THAT(shown.warnings, ElementsAre("Left out: wall2: is no session"));
  ASSERT_EQ(shown.tables.size(), 4u);
  const Table& wand = shown.tables[0];
  EXPECT_EQ(wand.rows.size(), 1 + wand_method_names().size());
  EXPECT_EQ(wand.printed, "calibration");
  EXPECT_THAT(
      rows_with(wand, "measured"),
      ElementsAre(
          "the paper, measured | - | laser meter | 50 | - | 0.73 | 0.85 | - | - | 100 | - | - | - | - | - | "
          "20.0 | not stated"));
  // 1 and 3 cm by one sensor, 2 and 4 by the other; t of one degree of freedom, and no length is below 0
  EXPECT_THAT(
      rows_with(wand, "ours"),
      ElementsAre("ours | bench | stated distances | 4 | 4 | 2.50 (0.00 to 8.85) | 1.29 | 3.50 (0.00 to "
                  "9.85) | 1.29 | 8 | 7 | 10.14 | 4.00 | 36.80 | 1 | 50.0 | found 87.5 %, nothing 12.5 %"));
  EXPECT_EQ(wand.columns[15].name, "answered below 0.5 m (%)");
  EXPECT_EQ(shown.tables[1].rows.size(), kMainWandMethods.size() * place_bins().size());
  EXPECT_THAT(rows_with(shown.tables[1], "ours | bench | distance from"),
              ElementsAre("ours | bench | distance from 3.75 m | 0 | 0 | - | -"));
  EXPECT_THAT(rows_with(shown.tables[1], "ours | bench | distance below"),
              ElementsAre("ours | bench | distance below 0.5 m | 2 | 1 | 50.00 | 50.00"));
  EXPECT_THAT(
      rows_of(shown.tables[2]),
      ElementsAre(
          "the paper | - | 1000 | 2.000 | - | - | - | - | - | - | - | - | - | - | columns 0 to 150 and 350 "
          "to "
          "520: \"much higher\" than the middle",
          "wall | k1 | 7 | 2.010 | 10.00 | 2.86 | 1.00 | 20.00 | 20.15 | 20.00 | 0.99 | 20.00 | 20.15 "
          "| 50.00 | "));
  EXPECT_THAT(rows_of(shown.tables[3]), ElementsAre("refined | k1 | 1.00 | 3.00 | 1.15 | 2.29 | ",
                                                    "refined | k2 | 3.00 | 3.00 | 1.15 | 2.29 | "));
  EXPECT_EQ(shown.tables[1].shown, Table::Placement::first);
  EXPECT_EQ(shown.tables[2].shown, Table::Placement::detail);
  EXPECT_EQ(
      shown.errata.at("E17"),
      "error of the distance inside the recommended range, bench: an unknown distance (no answer), 0 of 0 "
      "answered (corrected: an unknown distance (no answer), 0 of 0 answered)");
  EXPECT_THAT(
      shown.sentences,
      Contains("bench, recorded (stated distances), error of the distance inside the recommended range: ours "
               "2.50 cm (95 % interval 0.00 to 8.85 cm), 4 of 4 answered; the paper's way as printed an "
               "unknown distance (no answer), 0 of 0 answered."));
  EXPECT_THAT(shown.sentences, Contains(HasSubstr("here the depth lies 0.99 to 0.99 times as far")));
  EXPECT_THAT(shown.sentences, testing::Not(Contains(HasSubstr("Every simulated sensor"))));
  summary.simulated = true;
  EXPECT_THAT(calibration_tables(summary, recordings).sentences,
              Contains(HasSubstr("Every simulated sensor")));
  EXPECT_EQ(calibration_tables(summary, recordings).about,
            "Calibration by 1 recording of a ball and 1 wall, **simulated**.");
}

TEST(CalibrationTables, APartThatWasNotRunGivesNone) {
  CalibrationRecordings recordings = ball_and_wall();
  recordings.wands[0].poses.clear();
  recordings.walls.push_back(recordings.walls[0]);
  recordings.walls[1].recording = "other";
  StoredTables shown = calibration_tables(summary_of(recordings), recordings);
  EXPECT_EQ(shown.tables.size(), 3u);
  EXPECT_FALSE(shown.errata.contains("E4"));
  EXPECT_EQ(shown.about, "Calibration by 1 recording of a ball and 2 walls, recorded.");
  recordings.wands.clear();
  shown = calibration_tables(summary_of(recordings), recordings);
  EXPECT_EQ(shown.tables.size(), 1u);
  EXPECT_TRUE(shown.errata.empty());
  EXPECT_EQ(shown.about, "Calibration by 0 recordings of a ball and 2 walls, recorded.");
  EXPECT_TRUE(calibration_tables({}, {}).tables.empty());
  recordings = ball_and_wall();
  recordings.walls.clear();
  EXPECT_EQ(calibration_tables(summary_of(recordings), recordings).tables.size(), 3u);
  EXPECT_TRUE(calibration_tables(summary_of(recordings), recordings).errata.contains("E19"));
}

TEST(CalibrationFigures, AreMediansByDistanceAndAngleAndTheColumnsOfAWall) {
  CalibrationRecordings recordings = ball_and_wall();
  recordings.walls.push_back(recordings.walls[0]);
  recordings.walls[1].recording = "far";
  recordings.walls[1].distance_m = 3.0;
  const std::vector<Figure> figures = calibration_figures(false, recordings);
  ASSERT_EQ(figures.size(), 2u);
  const Figure& wand = figures[0];
  EXPECT_TRUE(wand.is_first);
  EXPECT_THAT(wand.panels, ElementsAre("ours"));
  ASSERT_EQ(wand.series.size(), 2u);  // 0.1 rad are 5.7 degrees, 0.2 are 11.5
  EXPECT_EQ(wand.series[0].name, "0 to 9°");
  ASSERT_EQ(wand.series[0].points.size(), 2u);  // at 0.4 m one sensor answers, by 50 cm
  EXPECT_EQ(wand.series[0].points[0].x, 0.375);
  EXPECT_NEAR(wand.series[0].points[0].y, 50.0, 1e-9);
  EXPECT_EQ(wand.series[0].points[1].x, 1.125);
  EXPECT_NEAR(wand.series[0].points[1].y, 1.5, 1e-9);
  EXPECT_EQ(wand.series[1].name, "9 to 18°");
  ASSERT_EQ(wand.series[1].points.size(), 2u);
  EXPECT_NEAR(wand.series[1].points[1].y, 5.5, 1e-9);
  EXPECT_EQ(wand.bands[0].to, 3.0);
  EXPECT_EQ(wand.lines[0].y, 0.73);
  const Figure& wall = figures[1];
  ASSERT_EQ(wall.series.size(), 2u);  // of the wall nearest to 2 m
  EXPECT_EQ(wall.series[0].name, "k1: depth from the plane");
  EXPECT_EQ(wall.series[1].group, "sideways by eq. 4 as printed (E2)");
  EXPECT_EQ(wall.series[0].points.size(), 512u);
  EXPECT_EQ(wall.series[0].points[200].x, 200.0);
  EXPECT_NEAR(wall.series[0].points[200].y, 50.0, 1e-9);
  ASSERT_EQ(wall.bands.size(), 2u);
  EXPECT_EQ(wall.bands[1].from, 350.0);
  EXPECT_EQ(wall.bands[1].to, 511.0);  // the image ends there
  EXPECT_THAT(wall.caption, HasSubstr("over 7 frames, one line a sensor (wall, 2.0 m)"));
  EXPECT_TRUE(calibration_figures(false, {}).empty());
}

}  // namespace
}  // namespace trilat
