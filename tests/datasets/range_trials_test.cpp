// SPDX-License-Identifier: MIT
#include "datasets/synthetic/range_trials.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <hwy/highway.h>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

constexpr std::size_t kTrials = 20'000;

RangeTrialModel model_with(TrialError error, double low_m, double high_m) {
  RangeTrialModel model;
  model.seed = 0x123456789ABCDEF0;
  model.sensors = 4;
  model.sensor_m = {{{2.0, 0.3, 0.0}, {0.0, 2.3, 2.0}, {-2.0, 0.3, 0.0}, {0.0, 2.3, -2.0}}};
  model.error = error;
  model.low_m = low_m;
  model.high_m = high_m;
  return model;
}

// Trials with all their rows.
struct Trials {
  std::size_t count;
  std::vector<double> truth_m, range_m, mean_m;

  Trials(const RangeTrialModel& model, std::uint64_t first, std::size_t n)
      : count((n + kTrialBlock - 1) / kTrialBlock * kTrialBlock),
        truth_m(3 * count),
        range_m(static_cast<std::size_t>(model.sensors) * count),
        mean_m(3 * count) {
    make_range_trials(model, first, n, {count, truth_m.data(), range_m.data(), mean_m.data()});
  }
  double distance_m(const RangeTrialModel& model, std::size_t sensor, std::size_t i) const {
    const auto& s = model.sensor_m[sensor];
    return std::hypot(truth_m[i] - s[0], truth_m[count + i] - s[1], truth_m[2 * count + i] - s[2]);
  }
  double error_m(const RangeTrialModel& model, std::size_t sensor, std::size_t i) const {
    return range_m[sensor * count + i] - distance_m(model, sensor, i);
  }
  double from_truth_m(const std::vector<double>& rows, std::size_t i) const {
    return std::hypot(rows[i] - truth_m[i], rows[count + i] - truth_m[count + i],
                      rows[2 * count + i] - truth_m[2 * count + i]);
  }
};

struct RangeMoments {
  double mean = 0.0, mean_magnitude = 0.0, least_magnitude = 1e300, largest_magnitude = 0.0, positive = 0.0;
};

RangeMoments moments_of_errors(const RangeTrialModel& model) {
  const Trials trials(model, 0, kTrials);
  RangeMoments m;
  for (std::size_t i = 0; i < kTrials; ++i) {
    const double e = trials.error_m(model, 1, i);
    m.mean += e / kTrials;
    m.mean_magnitude += std::abs(e) / kTrials;
    m.least_magnitude = std::min(m.least_magnitude, std::abs(e));
    m.largest_magnitude = std::max(m.largest_magnitude, std::abs(e));
    m.positive += e > 0.0 ? 1.0 / kTrials : 0.0;
  }
  return m;
}

TEST(RangeTrials, DrawTheUniformsOfARandomStream) {
  const RangeTrialModel model = model_with(TrialError::range_signed, 0.0, 0.0);
  const double low_m[] = {-0.6, 0.1, -0.6}, high_m[] = {0.6, 1.9, 0.6};
  for (const std::uint64_t first : {std::uint64_t{0}, std::uint64_t{0xFFFFFFF8}, std::uint64_t{1} << 40}) {
    const Trials trials(model, first, 64);
    for (std::size_t i = 0; i < 64; ++i)
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        const RandomStream stream{model.seed, Purpose::range_trial, first + i};
        const double share = stream.uniform(trial_index::kJoint + axis);
        EXPECT_NEAR(trials.truth_m[axis * trials.count + i],
                    low_m[axis] + share * (high_m[axis] - low_m[axis]), 1e-12)
            << first + i << " " << axis;
      }
  }
}

TEST(RangeTrials, AJointInTheVolumeFillsItAndAtTheCentreStaysThere) {
  RangeTrialModel model = model_with(TrialError::range_signed, 0.0, 0.0);
  const Trials trials(model, 0, kTrials);
  const double low_m[] = {-0.6, 0.1, -0.6}, high_m[] = {0.6, 1.9, 0.6};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto from = trials.truth_m.begin() + static_cast<std::ptrdiff_t>(axis * trials.count);
    const auto [least, largest] = std::minmax_element(from, from + kTrials);
    EXPECT_NEAR(*least, low_m[axis], 0.001);
    EXPECT_NEAR(*largest, high_m[axis], 0.001);
    EXPECT_GE(*least, low_m[axis]);
    EXPECT_LE(*largest, high_m[axis]);
  }
  for (std::size_t i = 0; i < kTrials; ++i) EXPECT_NEAR(trials.error_m(model, 2, i), 0.0, 1e-15);
  model.joint = TrialJoint::centre;
  const Trials centred(model, 5, 3);
  EXPECT_EQ(centred.truth_m[1], 0.0);
  EXPECT_EQ(centred.truth_m[centred.count + 1], 1.0);
}

TEST(RangeTrials, ASignedErrorIsUniformInItsRangeAndHasEitherSignAsOften) {
  const RangeMoments m = moments_of_errors(model_with(TrialError::range_signed, 0.15, 0.30));
  EXPECT_NEAR(m.positive, 0.5, 0.01);
  EXPECT_NEAR(m.mean, 0.0, 0.005);
  EXPECT_NEAR(m.mean_magnitude, 0.225, 0.001);
  EXPECT_NEAR(m.least_magnitude, 0.15, 1e-4);
  EXPECT_NEAR(m.largest_magnitude, 0.30, 1e-4);
}

TEST(RangeTrials, AGaussianErrorHasTheMeanMagnitudeOfTheMiddleOfItsRange) {
  const RangeTrialModel model = model_with(TrialError::gaussian, 0.05, 0.15);
  const RangeMoments m = moments_of_errors(model);
  EXPECT_NEAR(m.mean_magnitude, 0.1, 0.002);
  EXPECT_NEAR(m.mean, 0.0, 0.003);
  const Trials trials(model, 0, 1000);
  const double sigma_m = 0.1 * std::sqrt(std::acos(-1.0) / 2.0);
  for (std::size_t i = 0; i < 1000; ++i) {
    const RandomStream stream{model.seed, Purpose::range_trial, i};
    const double normal =
        stream.normal(trial_index::kSensor + trial_index::kPerSensor + trial_index::kRangeError);
    EXPECT_NEAR(trials.error_m(model, 1, i), sigma_m * normal, 1e-14);
  }
}

// From far away the range error is the displacement along the line of sight, which is uniform within the
// length either way when directions are uniform on the sphere.
TEST(RangeTrials, ADisplacementHasItsLengthAndAnyDirection) {
  RangeTrialModel model = model_with(TrialError::displacement, 0.2, 0.2);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    model.sensor_m[1] = {0.0, 0.0, 0.0};
    model.sensor_m[1][axis] = 1e6;
    const RangeMoments m = moments_of_errors(model);
    EXPECT_NEAR(m.largest_magnitude, 0.2, 1e-3) << axis;
    EXPECT_NEAR(m.mean_magnitude, 0.1, 0.002) << axis;
    EXPECT_NEAR(m.mean, 0.0, 0.003) << axis;
  }
}

TEST(RangeTrials, TheMeanOfOneSensorIsItsDisplacedJointAndItsRangeAgrees) {
  RangeTrialModel model = model_with(TrialError::displacement, 0.05, 0.15);
  model.sensors = 1;
  const Trials trials(model, 0, kTrials);
  double sum_m = 0.0;
  for (std::size_t i = 0; i < kTrials; ++i) {
    const double length_m = trials.from_truth_m(trials.mean_m, i);
    EXPECT_GE(length_m, 0.05 - 1e-12);
    EXPECT_LE(length_m, 0.15 + 1e-12);
    sum_m += length_m;
    const auto& s = model.sensor_m[0];
    EXPECT_NEAR(trials.range_m[i],
                std::hypot(trials.mean_m[i] - s[0], trials.mean_m[trials.count + i] - s[1],
                           trials.mean_m[2 * trials.count + i] - s[2]),
                1e-14);
  }
  EXPECT_NEAR(sum_m / kTrials, 0.1, 0.001);
}

// The joint does not depend on the error model, and errors depend on the range by scaling only.
TEST(RangeTrials, AllCellsSeeTheSameNoise) {
  const RangeTrialModel small = model_with(TrialError::range_signed, 0.0, 0.05);
  const RangeTrialModel large = model_with(TrialError::range_signed, 0.0, 0.30);
  const Trials a(small, 100, 64), b(large, 100, 64), c(model_with(TrialError::gaussian, 0.0, 0.3), 100, 64);
  EXPECT_EQ(a.truth_m, b.truth_m);
  EXPECT_EQ(a.truth_m, c.truth_m);
  for (std::size_t i = 0; i < 64; ++i)
    EXPECT_NEAR(6.0 * a.error_m(small, 3, i), b.error_m(large, 3, i), 1e-14);
}

TEST(RangeTrials, ATrialIsTheSameWhereverABlockBegins) {
  const RangeTrialModel model = model_with(TrialError::displacement, 0.05, 0.15);
  const Trials all(model, 0, 40), tail(model, 13, 8);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(all.truth_m[13 + i], tail.truth_m[i]);
    EXPECT_EQ(all.range_m[3 * all.count + 13 + i], tail.range_m[3 * tail.count + i]);
  }
}

// 0 stands for plain C++, without vectors.
TEST(RangeTrials, EveryInstructionSetGivesTheSameBits) {
  for (const TrialError error : {TrialError::range_signed, TrialError::displacement, TrialError::gaussian}) {
    const RangeTrialModel model = model_with(error, 0.05, 0.15);
    const Trials widest(model, 7, 1000);
    for (const std::int64_t target :
         {std::int64_t{0}, std::int64_t{HWY_SSE4}, std::int64_t{HWY_AVX2}, std::int64_t{HWY_AVX3}}) {
      if (target != 0 && (hwy::SupportedTargets() & target) == 0) continue;
      hwy::GetChosenTarget().Update(target);
      const Trials narrow(model, 7, 1000);
      hwy::GetChosenTarget().DeInit();
      EXPECT_EQ(narrow.truth_m, widest.truth_m) << target;
      EXPECT_EQ(narrow.range_m, widest.range_m) << target;
      EXPECT_EQ(narrow.mean_m, widest.mean_m) << target;
    }
  }
}

}  // namespace
}  // namespace trilat
