// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "reports/figures/figures.h"
#include "tests/reports/summaries.h"
#include "tests/reports/written_samples.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

double wave_m(double time_s) { return 1.0 + 0.1 * std::sin(2.0 * time_s); }
double wave_of(std::size_t, double time_s, std::size_t) { return wave_m(time_s); }

std::vector<std::string> names_of(const Figure& figure) {
  std::vector<std::string> names;
  for (const FigureSeries& series : figure.series) names.push_back(series.name);
  return names;
}

TEST(Trajectories, EveryConditionIsDrawnOnceByItsFirstTakeWithTruth) {
  const ScratchFolder folder;
  write_samples(
      folder.path(),
      samples_of({"mean"}, {{"p01-w", 30, "walking"},
                            {"p02-w", 30, "walking"},
                            {"p03-w", 30, "walking"},
                            {"p02-a", 30, "arm_swing"}}),
      [](std::size_t take, double t, std::size_t) { return take == 0 ? kNoNumber : wave_m(t); },
      [](std::size_t take, double t, std::size_t, std::size_t) { return take == 0 ? kNoNumber : wave_m(t); });
  const auto figures = trajectory_figures(folder.path(), hand_made_summary());
  ASSERT_EQ(figures.size(), 2u);
  EXPECT_THAT(figures[0].title, HasSubstr("take p02-w, simulated"));
  EXPECT_THAT(figures[1].title, HasSubstr("take p02-a"));
  EXPECT_THAT(figures[1].title, HasSubstr("arm swing"));
  EXPECT_EQ(figures[0].id, "trajectory-walking-wrist_right");
  EXPECT_EQ(figures[1].id, "trajectory-arm_swing-head");  // no elbow, so the first joint
}

TEST(Trajectories, AJointWithoutAnyTruthGivesWayToOneThatHasIt) {
  const ScratchFolder folder;
  write_samples(
      folder.path(), samples_of({"mean"}, {{"p01", 30, "walking"}}),
      [](std::size_t, double t, std::size_t joint) { return joint == 1 ? kNoNumber : wave_m(t); },
      [](std::size_t, double t, std::size_t, std::size_t) { return wave_m(t); });
  const auto figures = trajectory_figures(folder.path(), hand_made_summary());
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_EQ(figures[0].id, "trajectory-walking-head");
}

TEST(Trajectories, GapsOfTheTruthAndOfTheMethodEndTheLines) {
  const ScratchFolder folder;
  write_samples(
      folder.path(), samples_of({"mean"}, {{"p01", 90, "walking"}}),
      [](std::size_t, double t, std::size_t) { return t > 0.99 && t < 1.99 ? kNoNumber : 1.0; },
      [](std::size_t, double t, std::size_t, std::size_t) { return t < 0.5 ? kNoNumber : 1.5; });
  const auto figures = trajectory_figures(folder.path(), hand_made_summary());
  ASSERT_EQ(figures.size(), 1u);
  ASSERT_EQ(figures[0].series.size(), 2u);
  for (std::size_t i = 0; i < 90; ++i) {
    const double truth_cm = figures[0].series[0].points[i].y, mean_cm = figures[0].series[1].points[i].y;
    EXPECT_EQ(std::isnan(truth_cm), i >= 30 && i < 60) << i;
    EXPECT_EQ(std::isnan(mean_cm), i < 15) << i;
    if (std::isfinite(truth_cm)) {
      EXPECT_NEAR(truth_cm, 100.0, 1e-9);
    }
    if (std::isfinite(mean_cm)) {
      EXPECT_NEAR(mean_cm, 100.0, 1e-9);  // moved onto the truth
    }
  }
  EXPECT_THAT(csv_of(figures[0]), Not(HasSubstr("nan")));
}

TEST(Trajectories, AMethodThatNeverAnswersIsAnEmptyLine) {
  const ScratchFolder folder;
  write_samples(folder.path(), samples_of({"linear", "mean"}, {{"p01", 60, "walking"}}), wave_of,
                [](std::size_t, double t, std::size_t, std::size_t m) { return m ? wave_m(t) : kNoNumber; });
  const auto figures = trajectory_figures(folder.path(), hand_made_summary());
  ASSERT_EQ(figures.size(), 1u);
  ASSERT_THAT(names_of(figures[0]), ElementsAre("truth", "linear", "mean"));
  for (const FigurePoint& point : figures[0].series[1].points) EXPECT_TRUE(std::isnan(point.y));
  for (const FigurePoint& point : figures[0].series[2].points) EXPECT_TRUE(std::isfinite(point.y));
}

TEST(Trajectories, ShowTheFirstTenSecondsMovedByTheMeanOfTheWholeTake) {
  const ScratchFolder folder;
  constexpr std::uint64_t kManyInstants = 2400;  // more than one block
  write_samples(
      folder.path(), samples_of({"mean"}, {{"p01", kManyInstants, "walking"}}),
      [](std::size_t, double, std::size_t) { return 1.0; },
      [](std::size_t, double t, std::size_t, std::size_t) { return t < 39.99 ? 1.0 : 1.2; });
  const auto figures = trajectory_figures(folder.path(), hand_made_summary());
  ASSERT_EQ(figures.size(), 1u);
  for (const FigureSeries& series : figures[0].series) {
    ASSERT_EQ(series.points.size(), 301u);
    EXPECT_EQ(series.points.front().x, 0.0);
    EXPECT_NEAR(series.points.back().x, 10.0, 1e-9);
  }
  EXPECT_NEAR(figures[0].series[1].points[5].y, 90.0, 1e-6);
}

TEST(Trajectories, AFewMethodsAreShownThoseOfThePaperFirst) {
  const ScratchFolder folder;
  write_samples(
      folder.path(),
      samples_of({"rts", "mean", "single k1", "nonlinear", "geometric", "linear"}, {{"p01", 30, "walking"}}),
      wave_of, [](std::size_t, double t, std::size_t, std::size_t) { return wave_m(t); });
  const auto figures = trajectory_figures(folder.path(), hand_made_summary());
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_THAT(names_of(figures[0]), ElementsAre("truth", "linear", "geometric", "nonlinear", "mean"));
}

TEST(Trajectories, RecordedDataAreNotCalledSimulated) {
  const ScratchFolder folder;
  ResultsSummary summary = hand_made_summary();
  write_samples(folder.path(), samples_of({"mean"}, {{"p01", 30, "walking"}}), wave_of,
                [](std::size_t, double t, std::size_t, std::size_t) { return wave_m(t); });
  EXPECT_THAT(trajectory_figures(folder.path(), summary).at(0).caption, HasSubstr("Simulated"));
  summary.simulated = false;
  const Figure figure = trajectory_figures(folder.path(), summary).at(0);
  EXPECT_THAT(figure.title + figure.caption, Not(HasSubstr("imulated")));
}

TEST(Trajectories, WithoutSamplesOrTruthThereAreNoneAndADamagedFileIsNamed) {
  const ScratchFolder folder;
  EXPECT_TRUE(trajectory_figures(folder.path(), hand_made_summary()).empty());
  write_samples(
      folder.path(), samples_of({"mean"}, {{"p01", 30, "walking"}, {"p02", 0, "walking"}}),
      [](std::size_t, double, std::size_t) { return kNoNumber; },
      [](std::size_t, double t, std::size_t, std::size_t) { return wave_m(t); });
  EXPECT_TRUE(trajectory_figures(folder.path(), hand_made_summary()).empty());
  write_file(folder / "samples.h5", "no HDF5");
  EXPECT_THAT(message_of([&] { trajectory_figures(folder.path(), hand_made_summary()); }),
              HasSubstr("samples.h5"));
}

}  // namespace
}  // namespace trilat
