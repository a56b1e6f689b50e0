// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_plan.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/units.h"

namespace trilat {
namespace {

constexpr std::size_t kMostCells = 50'000;
constexpr double kMostTrialsInAll = 0x1p53;

RangeProblem problem_of(const SweepRig& rig) {
  RangeProblem problem;
  problem.count = static_cast<int>(rig.sensors_m.size());
  for (std::size_t i = 0; i < rig.sensors_m.size(); ++i) {
    problem.sensor_m[i] = {rig.sensors_m[i][0], rig.sensors_m[i][1], rig.sensors_m[i][2]};
    problem.range_m[i] = 1.0;
  }
  return problem;
}

// All but the rig, in the words of the study.
struct Choices {
  TrialJoint joint;
  TrialError error;
  ThresholdUnit unit;
  Gradient gradient;
  Curvature curvature;
  StopRule stop;
  Damping damping;
  SweepStart start;
};

template <class Visit>
void for_each_choice(const SweepSpec& spec, const Visit& visit) {
  for (const TrialJoint joint : spec.joints)
    for (const TrialError error : spec.error_models)
      for (const ThresholdUnit unit : spec.threshold_units)
        for (const Gradient gradient : spec.gradients)
          for (const Curvature curvature : spec.curvatures)
            for (const StopRule stop : spec.stops)
              for (const Damping damping : spec.dampings)
                for (const SweepStart start : spec.starts)
                  visit(Choices{joint, error, unit, gradient, curvature, stop, damping, start});
}

NonlinearOptions options_of(const Choices& c, const SweepSpec& spec) {
  NonlinearOptions o;
  o.gradient = c.gradient;
  o.curvature = c.curvature;
  o.stop = c.stop;
  o.damping = c.damping;
  o.max_iterations = static_cast<int>(spec.max_iterations);
  o.printed_unit_m = c.unit == ThresholdUnit::cm2 ? kMetresPerCentimetre : 1.0;
  o.start = c.start == SweepStart::linear ? Start::linear : Start::squared_ranges;
  return o;
}

// Root mean square of the range errors of a cell's trials.
double range_rms_m(TrialError error, const SweepSummary::ErrorRange& range) {
  const double low = range.low_m, high = range.high_m;
  const double rms_m = std::sqrt((low * low + low * high + high * high) / 3.0);
  switch (error) {
    case TrialError::range_signed:
      return rms_m;
    case TrialError::displacement:
      return rms_m / std::sqrt(3.0);
    case TrialError::gaussian:
      return 0.5 * (low + high) * std::sqrt(0.5 * std::numbers::pi);
  }
  TRILAT_CHECK(false, "an error model is one of the three");
}

bool makes_sense(const Choices& c, const SweepSpec& spec, const SweepReading& reading,
                 const RangeProblem& problem) {
  if (!contradiction_in(reading.options).empty()) return false;
  if (c.start == SweepStart::linear && !linear_position_m(problem, reading.options.linear)) return false;
  const bool unit_matters = c.stop != StopRule::step || c.gradient == Gradient::printed;
  return unit_matters || c.unit == spec.threshold_units.front();
}

SweepReading reading_of(const Choices& c, const SweepSpec& spec, const SweepRig& rig,
                        const RangeProblem& problem) {
  SweepReading reading;
  reading.options = options_of(c, spec);
  reading.trials.seed = spec.seed;
  reading.trials.sensors = problem.count;
  for (std::size_t i = 0; i < rig.sensors_m.size(); ++i) reading.trials.sensor_m[i] = rig.sensors_m[i];
  reading.trials.joint = c.joint;
  reading.trials.error = c.error;
  reading.start = c.start;
  reading.unit_m2 = c.unit == ThresholdUnit::cm2 ? kSquareMetresPerSquareCentimetre : 1.0;
  reading.plane = plane_of(problem);
  reading.has_hint = reading.plane.exact || c.damping == Damping::lm;
  SweepInterpretation& t = reading.text;
  t = {"",
       rig.name,
       rig.sensors_m,
       word_of(c.joint),
       word_of(c.error),
       word_of(c.unit),
       word_of(c.gradient),
       word_of(c.curvature),
       word_of(c.stop),
       word_of(c.damping),
       word_of(c.start)};
  t.id = fmt::format("{}/{}/{}/{}/{}/{}/{}/{}/{}", t.rig, t.joint, t.error_model, t.threshold_unit,
                     t.gradient, t.curvature, t.stop, t.damping, t.start);
  return reading;
}

// The pointer of the choice that rules out every other: what is left must be a start or a damping.
std::string emptying_choice(const SweepSpec& spec) {
  const bool only_linear = spec.starts == std::vector{SweepStart::linear};
  const bool some_fits = std::ranges::any_of(spec.dampings, [&](Damping damping) {
    return std::ranges::any_of(spec.gradients, [&](Gradient gradient) {
      DescentOptions options;
      options.damping = damping;
      options.gradient = gradient;
      options.curvature = spec.curvatures.front();
      return contradiction_in(options).empty();
    });
  });
  return only_linear && some_fits ? "/starts" : "/dampings";
}

void check_size(const SweepPlan& plan, const std::string& place) {
  if (plan.readings.empty())
    throw InputError(
        place + " " + emptying_choice(plan.spec),
        fmt::format("leaves nothing to compute: each of the {} combinations of its choices contradicts "
                    "itself (printed gradient with damping lm, newton without lm, a linear start for sensors "
                    "in one plane or fewer than four); name another choice, or a rig that has it",
                    plan.skipped));
  if (plan.cells() > kMostCells)
    throw InputError(place + " /rigs",
                     fmt::format("and the other lists ask for {} cells in all; at most {} can be kept",
                                 plan.cells(), kMostCells));
  const double in_all = static_cast<double>(plan.spec.trials) * static_cast<double>(plan.cells());
  if (in_all > kMostTrialsInAll)
    throw InputError(place + " /trials",
                     fmt::format("is {}, which with {} cells is more than 2^53 trials in all",
                                 plan.spec.trials, plan.cells()));
}

}  // namespace

SweepCellPlace place_of(const SweepPlan& plan, std::size_t cell) {
  const std::size_t ranges = plan.spec.ranges.size(), thresholds = plan.spec.thresholds.size();
  return {cell / ranges / thresholds, cell / ranges % thresholds, cell % ranges};
}

SweepCell with_place(const SweepPlan& plan, SweepCell cell, std::size_t number) {
  const SweepCellPlace place = place_of(plan, number);
  cell.interpretation = place.reading;
  cell.threshold = place.threshold;
  cell.range = place.range;
  return cell;
}

RangeTrialModel trials_of(const SweepPlan& plan, const SweepCellPlace& place) {
  RangeTrialModel model = plan.readings[place.reading].trials;
  model.low_m = plan.spec.ranges[place.range].low_m;
  model.high_m = plan.spec.ranges[place.range].high_m;
  return model;
}

NonlinearOptions options_of(const SweepPlan& plan, const SweepCellPlace& place) {
  const SweepReading& reading = plan.readings[place.reading];
  NonlinearOptions options = reading.options;
  options.threshold_m2 = plan.spec.thresholds[place.threshold] * reading.unit_m2;
  options.range_sigma_m = range_rms_m(reading.trials.error, plan.spec.ranges[place.range]);
  return options;
}

SweepPlan make_sweep_plan(const SweepSpec& spec, const std::string& place) {
  SweepPlan plan;
  plan.spec = spec;
  for (const SweepRig& rig : spec.rigs) {
    const RangeProblem problem = problem_of(rig);
    for_each_choice(spec, [&](const Choices& choices) {
      SweepReading reading = reading_of(choices, spec, rig, problem);
      if (makes_sense(choices, spec, reading, problem))
        plan.readings.push_back(std::move(reading));
      else
        ++plan.skipped;
    });
  }
  check_size(plan, place);
  return plan;
}

}  // namespace trilat
