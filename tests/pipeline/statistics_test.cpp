// SPDX-License-Identifier: MIT
#include "evaluators/metrics/statistics.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/results/item_store.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/accuracy/shown/accuracy_words.h"
#include "pipeline/errors/condition_errors.h"
#include "pipeline/errors/take_errors.h"
#include "tests/pipeline/campaigns.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

constexpr const char* kTwoMethods = R"("methods": [{"method": "mean"}, {"method": "single"},
    {"method": "nonlinear", "name": "never", "sensors": ["k1", "k2"]}])";

StudySpec statistics_study(const std::string& members) { return study_of(members + ", " + kTwoMethods); }

const Number& body_number(const ResultsSummary& summary, const std::string& method, const char* measure,
                          const char* statistic = "mean") {
  static const Number kNone;
  for (const Number& number : summary.numbers.all())
    if (number.method == method && number.measure == measure && number.statistic == statistic) return number;
  return kNone;
}

struct Evaluated {
  ScratchFolder folder;
  ResultsSummary of(const SimulationSpec& spec, const StudySpec& study) {
    return execute_study(study, simulate_into(folder / "campaign", spec), folder / "results", {});
  }
};

// The same estimates with fewer answers: whatever the alignment, there is no difference.
TEST(Statistics, AMethodIsNoBetterForAnsweringLess) {
  Evaluated evaluated;
  const ResultsSummary summary =
      evaluated.of(walking_spec(3, 4.0),
                   study_of(R"("alignments": ["none", "first", "mean", "rigid", "held_out", "joint_offset"],
                  "methods": [{"method": "nonlinear"},
                              {"method": "nonlinear", "name": "sparse", "max_iterations": 5}])"));
  int compared = 0;
  for (const Number& d : summary.numbers.all()) {
    if (d.method != "sparse" || d.statistic != "difference") continue;
    EXPECT_LT(std::abs(d.value), 1e-12) << d.group << ' ' << d.alignment;
    EXPECT_FALSE(is_significant(d));
    ++compared;
  }
  EXPECT_EQ(compared, 6 * 5);
  const double sparse = coverage_of(summary, "sparse", "walking", "wrist", "none");
  EXPECT_LT(sparse, 0.95);
  EXPECT_GT(sparse, 0.2);
}

TEST(Statistics, EveryAnsweredCellOfSeveralParticipantsHasAnIntervalAroundItsValue) {
  Evaluated evaluated;
  const ResultsSummary summary =
      evaluated.of(walking_spec(5, 3.0), statistics_study(R"("alignments": ["none", "held_out"])"));
  int answered = 0;
  for (const Number& error : summary.numbers.all()) {
    if (error.measure != "distance" || error.statistic != "mean" || !error.take.empty()) continue;
    const std::string what = error.method + " " + error.group + " " + error.alignment;
    EXPECT_NE(error.method, "never") << what;
    EXPECT_EQ(error.clusters, 5u) << what;
    EXPECT_LT(error.low, error.value) << what;
    EXPECT_GT(error.high, error.value) << what;
    ++answered;
  }
  EXPECT_EQ(answered, 5 * 5 * 2);  // mean and four sensors, four groups and their average, two alignments
  EXPECT_EQ(coverage_of(summary, "never", "walking", "wrist", "none"), 0.0);
  const Number* average = find_error(summary, "mean", "walking", kAverageGroup, "none");
  ASSERT_NE(average, nullptr);
  double sum_m = 0.0;
  for (const std::string& group : summary.groups)
    sum_m += find_error(summary, "mean", "walking", group, "none")->value;
  EXPECT_NEAR(average->value, sum_m / 4.0, 1e-15);
}

TEST(Statistics, DifferencesAreOfTheSamplesThatBothAnswered) {
  Evaluated evaluated;
  const ResultsSummary summary = evaluated.of(
      synchronised(walking_spec(4, 2.0)), statistics_study(R"("alignments": ["none"], "reference": "mean")"));
  EXPECT_EQ(find_difference(summary, "mean", "walking", "wrist", "none"), nullptr);
  const Number* d = find_difference(summary, "single k1", "walking", "wrist", "none");
  const Number* reference = find_error(summary, "mean", "walking", "wrist", "none");
  const Number* method = find_error(summary, "single k1", "walking", "wrist", "none");
  ASSERT_TRUE(d && reference && method);
  EXPECT_EQ(d->clusters, 4u);
  ASSERT_EQ(d->n, method->n);  // the reference answers wherever one of its sensors does
  ASSERT_EQ(method->n, reference->n);
  EXPECT_NEAR(d->value, method->value - reference->value, 1e-12);
  const Number* share =
      find_difference(summary, "single k1", "walking", "wrist", "none", "relative_difference");
  ASSERT_TRUE(share);
  EXPECT_NEAR(share->value, d->value / reference->value, 1e-11);
  EXPECT_LT(d->low, d->value);
  EXPECT_GT(d->high, d->value);
  const double t = d->value / ((d->high - d->value) / student_quantile(3));
  EXPECT_NEAR(d->p, student_two_sided(t, 3), 1e-12);
  EXPECT_EQ(find_difference(summary, "never", "walking", "wrist", "none"), nullptr);
  EXPECT_NE(find_difference(summary, "single k1", "walking", kAverageGroup, "none"), nullptr);
}

TEST(Statistics, AMethodIsNoBetterThanItself) {
  Evaluated evaluated;
  const ResultsSummary summary =
      evaluated.of(walking_spec(4), study_of(R"("alignments": ["mean"], "methods": [{"method": "mean"},
                                   {"method": "mean", "name": "again"}])"));
  int compared = 0;
  for (const Number& d : summary.numbers.all()) {
    if (d.against.empty()) continue;
    EXPECT_EQ(d.value, 0.0);
    EXPECT_EQ(d.low, 0.0);
    EXPECT_EQ(d.high, 0.0);
    EXPECT_FALSE(is_significant(d));
    ++compared;
  }
  EXPECT_EQ(compared, 2 * 5);  // in metres and as a share
}

TEST(Statistics, ATakeOfOneBlockHasValuesAndNoInterval) {
  Evaluated evaluated;
  SimulationSpec spec = walking_spec(1, 2.0);
  spec.activities.push_back(spec.activities[0]);
  spec.activities[1].activity = Activity::standing;
  const ResultsSummary summary = evaluated.of(spec, statistics_study(R"("alignments": ["mean"])"));
  const Number* cell = find_error(summary, "mean", "walking", "head", "mean");
  ASSERT_NE(cell, nullptr);
  EXPECT_EQ(cell->clusters, 1u);
  EXPECT_TRUE(std::isnan(cell->low) && std::isnan(cell->high));
  const Number* d = find_difference(summary, "single k1", "walking", "head", "mean");
  EXPECT_TRUE(std::isfinite(d->value) && std::isnan(d->low));
  EXPECT_TRUE(summary.best.empty());  // no method is best without an interval
  EXPECT_THAT(accuracy_findings(summary), testing::Each(testing::HasSubstr("no method is called best")));
}

// One take of another activity among six: its clusters are its own blocks.
TEST(Statistics, ClustersAreThoseOfTheCondition) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(4, 11.0));
  campaign.takes[3].activity = "sitting";
  const ResultsSummary summary =
      execute_study(statistics_study(R"("alignments": ["mean"])"), campaign, folder / "results", {});
  EXPECT_EQ(find_error(summary, "mean", "walking", "head", "mean")->clusters, 3u);
  const Number* sitting = find_error(summary, "mean", "sitting", "head", "mean");
  EXPECT_EQ(sitting->clusters, 3u);  // blocks of five seconds
  EXPECT_TRUE(std::isfinite(sitting->low));
  campaign.takes[2].activity = "sitting";
  const ResultsSummary two =
      execute_study(statistics_study(R"("alignments": ["mean"])"), campaign, folder / "two", {});
  EXPECT_EQ(find_error(two, "mean", "walking", "head", "mean")->clusters, 2u);
  EXPECT_EQ(find_error(two, "mean", "sitting", "head", "mean")->clusters, 2u);
}

// All takes of one participant in a condition are one cluster; of fewer than three participants each take is.
TEST(Statistics, TakesOfOneParticipantShareTheCluster) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(6));
  const auto clusters_of = [&](std::size_t participants) {
    for (std::size_t t = 0; t < campaign.takes.size(); ++t)
      campaign.takes[t].participant = "p" + std::to_string(t % participants);
    const ResultsSummary summary =
        execute_study(statistics_study(R"("alignments": ["mean"])"), campaign, folder / "results", {});
    EXPECT_EQ(summary.participants, participants);
    return find_error(summary, "mean", "walking", "head", "mean")->clusters;
  };
  EXPECT_EQ(clusters_of(3), 3u);
  EXPECT_EQ(clusters_of(2), 6u);
}

TEST(Statistics, BlocksOfASingleTakeAreItsClusters) {
  Evaluated evaluated;
  const ResultsSummary summary =
      evaluated.of(walking_spec(1, 16.0), statistics_study(R"("alignments": ["mean"])"));
  const Number* cell = find_error(summary, "mean", "walking", "head", "mean");
  ASSERT_TRUE(cell);
  EXPECT_EQ(cell->clusters, 4u);  // of five seconds
  EXPECT_LT(cell->low, cell->value);
}

// In each condition the only take's blocks are the clusters, whatever number the take has in the campaign.
TEST(Statistics, SeveralActivitiesOfOneParticipantHaveIntervalsEach) {
  Evaluated evaluated;
  SimulationSpec spec = walking_spec(1, 16.0);
  spec.activities.push_back(spec.activities[0]);
  spec.activities[1].activity = Activity::arm_swing;
  spec.activities[1].duration_s = 11.0;
  const ResultsSummary summary = evaluated.of(spec, statistics_study(R"("alignments": ["mean"])"));
  for (const auto& [condition, clusters] : {std::pair{"walking", 4u}, std::pair{"arm_swing", 3u}})
    for (const char* group : {"head", "wrist", kAverageGroup}) {
      const Number* cell = find_error(summary, "mean", condition, group, "mean");
      ASSERT_TRUE(cell) << condition;
      EXPECT_EQ(cell->clusters, clusters) << condition;
      EXPECT_LT(cell->low, cell->value);
      EXPECT_GT(cell->high, cell->value);
      EXPECT_LT(cell->high, 1.0);
      const Number* d = find_difference(summary, "single k1", condition, group, "mean");
      ASSERT_TRUE(d);
      EXPECT_TRUE(std::isfinite(d->low) && std::isfinite(d->high)) << condition;
    }
}

TEST(Statistics, ATakeThatFailedIsNoParticipant) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(5));
  campaign.takes[2].mocap = folder / "absent.csv";
  const ResultsSummary summary =
      execute_study(statistics_study(R"("alignments": ["mean"])"), campaign, folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 1u);
  EXPECT_EQ(summary.participants, 4u);
  const Number* cell = find_error(summary, "mean", "walking", "head", "mean");
  EXPECT_EQ(cell->clusters, 4u);
  EXPECT_TRUE(std::isfinite(cell->low));
}

TEST(Statistics, BlocksAreFiveSecondsOrATwelfthOfTheTake) {
  EXPECT_EQ(block_instants(1, 30.0), 150u);
  EXPECT_EQ(block_instants(12 * 150, 30.0), 150u);
  EXPECT_EQ(block_instants(12 * 150 + 1, 30.0), 151u);
  EXPECT_EQ(block_instants(120'000, 30.0), 10'000u);
  EXPECT_EQ(block_instants(10, 0.1), 1u);
}

// With a single take its blocks of time are the clusters: they tell methods apart and give intervals.
TEST(Statistics, MethodsOfASingleTakeAreMarked) {
  Evaluated evaluated;
  const ResultsSummary summary = evaluated.of(
      walking_spec(1, 30.0), study_of(R"("alignments": ["mean"], "reference": "mean", "methods": [
          {"method": "mean"}, {"method": "mean", "name": "same"}, {"method": "single", "sensors": ["k2"]}])"));
  std::size_t told_apart = 0;
  for (const BestMethod& best : summary.best) {
    if (best.method == "single k2") continue;
    EXPECT_THAT(best.not_distinguished, testing::Contains(best.method == "mean" ? "same" : "mean"))
        << best.group << " " << best.method;
    told_apart += best.not_distinguished.size() == 1 ? 1 : 0;
  }
  EXPECT_GT(told_apart, 0u);
}

TEST(Statistics, TwoBlocksOfTimeAreEnoughToMarkAMethod) {
  Evaluated evaluated;
  const ResultsSummary summary =
      evaluated.of(walking_spec(1, 9.0), study_of(R"("alignments": ["mean"], "reference": "mean", "methods": [
          {"method": "mean"}, {"method": "mean", "name": "same"}])"));
  ASSERT_FALSE(summary.best.empty());
  for (const BestMethod& best : summary.best) EXPECT_EQ(best.not_distinguished.size(), 1u) << best.group;
}

// A method whose error is larger for every participant is not marked; one with equal estimates is.
TEST(Statistics, NoMarkContradictsADifference) {
  Evaluated evaluated;
  const ResultsSummary summary =
      evaluated.of(walking_spec(6, 4.0), study_of(R"("alignments": ["mean"], "reference": "mean",
          "methods": [{"method": "mean"}, {"method": "mean", "name": "same"}, {"method": "linear"},
                      {"method": "single", "sensors": ["k2"]}])"));
  ASSERT_FALSE(summary.best.empty());
  for (const BestMethod& best : summary.best) {
    ASSERT_THAT(best.method, testing::AnyOf("mean", "same"));
    EXPECT_THAT(best.not_distinguished, testing::Contains(best.method == "mean" ? "same" : "mean"));
    const Number* linear = find_difference(summary, "linear", best.condition, best.group, "mean");
    ASSERT_TRUE(linear);
    if (linear->low > 0.01) {
      EXPECT_THAT(best.not_distinguished, testing::Not(testing::Contains("linear"))) << best.group;
    }
  }
}

TEST(Statistics, AJointThatIsNeverSeenLeavesTheOthersTheirIntervals) {
  Evaluated evaluated;
  const ResultsSummary summary =
      evaluated.of(walking_spec(4), study_of(R"("alignments": ["mean"], "reference": "never",
          "methods": [{"method": "mean"}, {"method": "nonlinear", "name": "never", "sensors": ["k1", "k2"]}])"));
  EXPECT_TRUE(std::isfinite(find_error(summary, "mean", "walking", "head", "mean")->low));
  EXPECT_EQ(summary.reference, "mean");  // nothing can be compared with silence
  EXPECT_EQ(find_difference(summary, "never", "walking", "head", "mean"), nullptr);
  for (const char* measure : {"mpjpe", "jerk"})
    EXPECT_TRUE(std::isnan(body_number(summary, "never", measure).value)) << measure;
  EXPECT_EQ(body_number(summary, "never", "within", "15_cm").value, 0.0);  // not answered is not near
}

TEST(Statistics, BodiesWithoutNoiseAreWhatTheTruthIs) {
  Evaluated evaluated;
  const ResultsSummary summary = evaluated.of(synchronised(without_noise(walking_spec(4, 2.0))),
                                              statistics_study(R"("alignments": ["none"])"));
  const Number &mpjpe = body_number(summary, "mean", "mpjpe"),
               &bone = body_number(summary, "mean", "bone", "sd");
  EXPECT_GT(mpjpe.n, 4u * 50u);
  EXPECT_EQ(mpjpe.clusters, 4u);
  EXPECT_LT(mpjpe.value, 1e-5);
  EXPECT_LT(body_number(summary, "mean", "pa_mpjpe").value, 1e-5);
  for (const char* radius : {"5_cm", "10_cm", "15_cm"})
    EXPECT_EQ(body_number(summary, "mean", "within", radius).value, 1.0);
  EXPECT_EQ(bone.n, 4u);  // upper arms and forearms
  EXPECT_LT(bone.value, 1e-4);
  const double truth_m_s3 = body_number(summary, "", "jerk", "mean_of_truth").value;
  EXPECT_NEAR(body_number(summary, "mean", "jerk").value, truth_m_s3, 0.1 * truth_m_s3 + 0.5);
}

TEST(Statistics, OccludedSamplesMakeConditionsOfTheirOwn) {
  Evaluated evaluated;
  SimulationSpec spec = walking_spec(4, 2.0);
  spec.body_tracker.least_visible_share = 0.5;  // what other parts of the body hide is inferred
  const ResultsSummary summary =
      evaluated.of(spec, statistics_study(R"("alignments": ["mean", "none"], "occluded_apart": true)"));
  EXPECT_THAT(summary.conditions, testing::ElementsAre("walking", "walking, occluded"));
  const Number* all = find_error(summary, "mean", "walking", "wrist", "none");
  const Number* occluded = find_error(summary, "mean", "walking, occluded", "wrist", "none");
  ASSERT_TRUE(all && occluded);
  const Number *asked = find_coverage(summary, "mean", "walking", "wrist", "none"),
               *asked_occluded = find_coverage(summary, "mean", "walking, occluded", "wrist", "none");
  ASSERT_TRUE(asked && asked_occluded);
  EXPECT_GT(asked_occluded->n, 0u);
  EXPECT_LT(asked_occluded->n, asked->n);
  EXPECT_LT(occluded->low, occluded->value);
  EXPECT_GT(summary.numbers.value(occluded->with({.statistic = "p95"})), occluded->value);
  const Number* d = find_difference(summary, "single k1", "walking, occluded", kAverageGroup, "none");
  ASSERT_NE(d, nullptr);
  EXPECT_GT(d->n, 0u);
  // apart, the numbers of all samples stay what they are
  const ResultsSummary plain = evaluated.of(spec, statistics_study(R"("alignments": ["mean", "none"])"));
  EXPECT_EQ(find_error(plain, "mean", "walking", "wrist", "none")->value, all->value);
  EXPECT_EQ(find_error(plain, "mean", "walking", "wrist", "none")->low, all->low);
}

}  // namespace
}  // namespace trilat
