// SPDX-License-Identifier: MIT
#include "pipeline/claims/study_measures.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "pipeline/calibration_study/place_samples.h"

namespace trilat {
namespace {

constexpr const char* kRuns = "recordings of a sensor";
constexpr const char* kUnits = "sensors";

// The first recording of stated distances: what a laser meter can tell.
const WandRecording* stated_distances(const CalibrationRecordings& s) {
  const auto found = std::ranges::find(s.wands, WandTruth::stated, &WandRecording::truth);
  return found == s.wands.end() ? nullptr : &*found;
}

// By sensor, the sums of the errors of the ball's distance within a zone.
WeightedRatio errors_in(const WandRecording& recording, const WandZone& zone) {
  const std::size_t method = wand_method("corrected by the mid-range"), sensors = recording.sensors.size();
  WeightedRatio mean{std::vector<double>(sensors, 0.0), std::vector<double>(sensors, 0.0), 1.0};
  const auto is_within = [](double value, const std::array<double, 2>& bounds) {
    return value >= bounds[0] && value < bounds[1];
  };
  for (const WandSample& sample : recording.samples) {
    if (sample.method != method || !std::isfinite(sample.distance_error_m)) continue;
    if (!is_within(sample.distance_m, zone.distance_m)) continue;
    if (!is_within(sample.angle_rad * kDegreesPerRad, zone.angle_deg)) continue;
    mean.numerator.at(sample.sensor) += sample.distance_error_m;
    mean.denominator.at(sample.sensor) += 1.0;
  }
  return mean;
}

Measurement lacking_wand() { return lacking("a calibration study with a ball at stated distances"); }

// Whether the last threshold but one is a compromise in an interpretation, at every error range: the last one
// takes twice its steps, and the first one errs by a tenth more.
bool is_compromise(const SweepSummary& s, std::size_t interpretation) {
  constexpr double kMoreSteps = 2.0, kLessAccurate = 1.1;
  const std::size_t last = s.thresholds - 1;
  for (std::size_t range = 0; range < s.ranges; ++range) {
    const SweepCell &first = s.cell(interpretation, 0, range),
                    &chosen = s.cell(interpretation, last - 1, range),
                    &smallest = s.cell(interpretation, last, range);
    if (!(s.value(smallest, kSweptSteps) >= kMoreSteps * s.value(chosen, kSweptSteps)) ||
        !(s.value(first, kSweptError) >= kLessAccurate * s.value(chosen, kSweptError)))
      return false;
  }
  return true;
}

// Outcome of one interpretation of Table I.
struct Interpretation {
  bool is_near = false;        // every error, as the mean distance or as the mean over axes
  bool is_compromise = false;  // C = 1e-4
};

Interpretation judge(const SweepSummary& s, std::size_t interpretation, const PrintedTable1& paper) {
  constexpr double kNear = 2.0, kAnswered = 0.9;
  Interpretation result{.is_compromise = is_compromise(s, interpretation)};
  std::array<bool, 2> near{true, true};
  for (std::size_t range = 0; range < s.ranges; ++range)
    for (std::size_t t = 0; t < s.thresholds; ++t) {
      const SweepCell& cell = s.cell(interpretation, t, range);
      const double printed_m = paper.rows[t].error_cm[range] / kCentimetresPerMetre;
      const bool answers = s.value(cell, kSweptAnswers) >= kAnswered;
      const std::array<double, 2> error_m{s.value(cell, kSweptError), axis_mean_m(s, cell)};
      for (const std::size_t k : {0u, 1u})
        near[k] = near[k] && answers && error_m[k] <= kNear * printed_m && error_m[k] >= printed_m / kNear;
    }
  result.is_near = near[0] || near[1];
  return result;
}

}  // namespace

Measurement acceptable_interpretations(const SweepSummary& s) {
  const PrintedTable1 paper = printed_table1();
  if (s.thresholds != paper.rows.size() || s.ranges != paper.ranges_cm.size() || s.thresholds < 3)
    return lacking("a sweep over the thresholds and error ranges of Table I");
  struct Count {
    int near = 0, compromise = 0;
  } printed, corrected;
  for (std::size_t r = 0; r < s.interpretations(); ++r) {
    const Interpretation interpretation = judge(s, r, paper);
    if (!interpretation.is_near) continue;
    Count& count = s.cell(r, 0, 0).gradient == "printed" ? printed : corrected;
    ++count.near;
    count.compromise += interpretation.is_compromise;
  }
  const int near = printed.near + corrected.near;
  if (near == 0)
    return lacking("an interpretation of Table I whose every error is that near the printed one");
  return {
      .what = fmt::format(
          "of {} acceptable interpretations of {}: {} of {} with equation 17 as printed, {} of {} corrected",
          near, s.interpretations(), printed.compromise, printed.near, corrected.compromise, corrected.near),
      .unit = "%",
      .number = static_cast<double>(printed.compromise + corrected.compromise) / near,
      .over = "interpretations, all of them listed"};
}

Measurement share_of_units(const ClocksSummary& clocks, const NumberKey& key) {
  std::vector<double> part, whole;
  for (const Number& unit : clocks.numbers.all()) {
    if (unit.take.empty() || unit.with(key) != unit) continue;
    part.push_back(std::round(unit.value * static_cast<double>(unit.n)));
    whole.push_back(static_cast<double>(unit.n));
  }
  if (whole.empty())
    return lacking(
        fmt::format("a study of clocks with {} of {}, {}", key.statistic, key.measure, key.method));
  return {.what = clocks.campaign, .unit = "%", .number = estimate_share(part, whole), .over = kRuns};
}

Measurement wand_error(const CalibrationRecordings& s, const WandZone& zone, double less_m) {
  const WandRecording* recording = stated_distances(s);
  if (!recording) return lacking_wand();
  Estimate error_m = solve_contrast({{errors_in(*recording, zone)}, {}});
  error_m.value -= less_m;
  return {.what = fmt::format("distance of the wand, less {:g} cm", kCentimetresPerMetre * less_m),
          .unit = "cm",
          .number = error_m,
          .over = kUnits};
}

Measurement wand_error(const CalibrationRecordings& s, const WandZone& zone, const WandZone& other) {
  const WandRecording* recording = stated_distances(s);
  if (!recording) return lacking_wand();
  const WeightedRatio base = errors_in(*recording, other);
  Contrast contrast{{errors_in(*recording, zone), base}, {base}};
  contrast.value[1].weight = -1.0;
  return {.what = "distance of the wand", .unit = "%", .number = solve_contrast(contrast), .over = kUnits};
}

}  // namespace trilat
