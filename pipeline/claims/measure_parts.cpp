// SPDX-License-Identifier: MIT
// Statistics of the sweep, of recordings and of the calibration.
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "evaluators/metrics/student.h"
#include "pipeline/claims/measures.h"

namespace trilat {
namespace {

struct Zone {
  std::array<double, 2> distance_m{}, angle_rad{};
  bool holds(const WandSample& s) const {
    return s.distance_m >= distance_m[0] && s.distance_m < distance_m[1] && s.angle_rad >= angle_rad[0] &&
           s.angle_rad < angle_rad[1];
  }
};

Zone read_zone(JsonObject zone) {
  const std::vector<double> distance_m = zone.numbers("distance_m", 2),
                            angle_deg = zone.numbers("angle_deg", 2);
  zone.finish();
  return {{distance_m[0], distance_m[1]}, {angle_deg[0] / kDegreesPerRad, angle_deg[1] / kDegreesPerRad}};
}

// By unit, the sums of the errors of the wand's distance within a zone: what a laser meter can tell.
WeightedRatio errors_in(const CalibrationSummary& s, std::size_t row, const Zone& zone) {
  WeightedRatio mean{std::vector<double>(s.units, 0.0), std::vector<double>(s.units, 0.0), 1.0};
  for (const WandSample& sample : s.wand_samples)
    if (sample.row == row && sample.unit < s.units && zone.holds(sample) &&
        std::isfinite(sample.distance_error_m)) {
      mean.numerator[sample.unit] += sample.distance_error_m;
      mean.denominator[sample.unit] += 1.0;
    }
  return mean;
}

}  // namespace

// Among the readings of Table I whose every error is near the printed one, the share in which a smaller
// threshold costs steps and gains accuracy. They are listed, not drawn: the share has no interval.
MeasuredPart measure_readings(JsonObject& part, const ClaimStudies& e) {
  const double factor = part.number("errors_within_factor"), answered = part.number("least_answered"),
               steps = part.number("least_steps_factor"), gain = part.number("least_error_factor");
  if (!e.evidence.sweep) return missing("results of the study table1_search");
  const SweepSummary& s = *e.evidence.sweep;
  const PrintedTable1 paper = printed_table1();
  const std::size_t last = s.thresholds.size() - 1;
  if (s.thresholds.size() != paper.rows.size() || s.ranges.size() != paper.ranges_cm.size() || last < 2)
    return missing("a sweep over the thresholds and error ranges of Table I");
  std::array<std::array<double, 2>, 2>
      counts{};  // printed, corrected gradient: acceptable, of those with a compromise
  for (std::size_t r = 0; r < s.interpretations.size(); ++r) {
    bool compromise = true;
    std::array<bool, 2> near{true, true};  // as the mean distance, as the mean over axes
    for (std::size_t range = 0; range < s.ranges.size(); ++range) {
      for (std::size_t t = 0; t <= last; ++t) {
        const SweepCell& cell = s.cell(r, t, range);
        const double printed_m = paper.rows[t].error_cm[range] / kCentimetresPerMetre;
        const bool answers = static_cast<double>(cell.answered) >= answered * static_cast<double>(cell.asked);
        const std::array<double, 2> error_m{cell.mae_m, cell.axis_mean_mae_m()};
        for (const std::size_t k : {0u, 1u})
          near[k] =
              near[k] && answers && error_m[k] <= factor * printed_m && error_m[k] >= printed_m / factor;
      }
      const SweepCell &first = s.cell(r, 0, range), &chosen = s.cell(r, last - 1, range),
                      &least = s.cell(r, last, range);
      compromise = compromise && least.mean_iterations >= steps * chosen.mean_iterations &&
                   first.mae_m >= gain * chosen.mae_m;
    }
    if (!near[0] && !near[1]) continue;
    auto& count = counts[s.interpretations[r].gradient == "printed" ? 0 : 1];
    count[0] += 1.0;
    count[1] += compromise ? 1.0 : 0.0;
  }
  const double acceptable = counts[0][0] + counts[1][0];
  if (acceptable == 0.0)
    return missing("a reading of Table I whose every error is that near the printed one");
  Measurement found;
  found.what = fmt::format(
      "of {} acceptable readings of {}: {} of {} with equation 17 as printed, {} of {} corrected", acceptable,
      s.interpretations.size(), counts[0][1], counts[0][0], counts[1][1], counts[1][0]);
  found.unit = "%";
  if (acceptable > 0.0) found.estimate = {100.0 * (counts[0][1] + counts[1][1]) / acceptable, 0.0, 2};
  return {.parts = {found}, .clusters = "readings, all of them listed"};
}

// Share of a network's clock errors below so many milliseconds, by one way to correct clocks; a cluster is a
// run of one sensor.
MeasuredPart measure_clock_share(JsonObject& part, const ClaimStudies& e) {
  const std::string method = part.text("method");
  const bool below_2ms = part.choice("below_ms", {"2", "4"}) == 0;
  for (std::size_t k = 0; e.evidence.recording && k < e.evidence.recording->clocks.size(); ++k) {
    const ClockErrorRow& row = e.evidence.recording->clocks[k];
    if (row.method != method || row.units.empty()) continue;  // the first network stands first
    WeightedRatio share;
    for (const ClockUnit& unit : row.units) {
      share.numerator.push_back(static_cast<double>(below_2ms ? unit.below_2ms : unit.below_4ms));
      share.denominator.push_back(static_cast<double>(unit.asked));
    }
    return {.parts = {{fmt::format("{}, {}", row.network, method), "%", percent_of({{share}, {}})}},
            .clusters = "runs of a sensor"};
  }
  return missing("results of the study table4 with " + method);
}

// Share of frames that the paper's queue takes; its standard error is that of the stored interval.
MeasuredPart measure_queue(JsonObject& part, const ClaimStudies& e) {
  const std::string method = part.text("method"), server = part.text("server");
  for (std::size_t k = 0; e.evidence.recording && k < e.evidence.recording->queues.size(); ++k) {
    const QueueRow& row = e.evidence.recording->queues[k];
    if (row.method != method || row.server != server || row.counts.came == 0) continue;
    const std::size_t clusters = e.evidence.recording->runs * e.evidence.recording->sensors;
    ContrastEstimate taken{static_cast<double>(row.counts.taken) / static_cast<double>(row.counts.came), kNaN,
                           clusters};
    if (clusters >= 2)
      taken.standard_error = (row.taken_high - row.taken_low) / (2.0 * student_quantile(clusters - 1));
    return {.parts = {{fmt::format("{}, {}, {}", row.network, method, server), "%", scaled(taken, 100.0)}},
            .clusters = "runs of a sensor"};
  }
  return missing("results of the study table4 with the queue of " + method);
}

// The error of the wand's distance in a zone: less a printed number, in cm, or against another zone, in
// percent of its error.
MeasuredPart measure_wand(JsonObject& part, const ClaimStudies& e) {
  const std::string method = part.text("method"), scene = part.text("scene", "far wall");
  const Zone zone = read_zone(part.object("zone"));
  const bool has_other = part.has("against");
  const Zone other = has_other ? read_zone(part.object("against")) : Zone{};
  const double less_cm = has_other ? 0.0 : part.number("less_cm");
  if (!e.evidence.calibration) return missing("results of the study calibration");
  const CalibrationSummary& s = *e.evidence.calibration;
  for (std::size_t row = 0; row < s.wand.size(); ++row) {
    if (s.wand[row].method != method || s.wand[row].scene != scene) continue;
    Contrast contrast{{errors_in(s, row, zone)}, {}};
    Measurement found{"distance of the wand, " + method, "cm", {}, {}};
    if (has_other) {
      contrast.base = {errors_in(s, row, other)};
      contrast.value.push_back(contrast.base.front());
      contrast.value.back().weight = -1.0;
      found.unit = "%";
      found.estimate = percent_of(contrast);
    } else {
      found.estimate = scaled(solve_contrast(contrast), kCentimetresPerMetre);
      found.what += fmt::format(", less {:g} cm", less_cm);
      found.estimate.value -= less_cm;
    }
    return {.parts = {std::move(found)}, .clusters = "sensor units"};
  }
  return missing(fmt::format("a calibration study with the wand by {} before a {}", method, scene));
}

// The depth error of an image row without its constant part: outer columns against those between.
MeasuredPart measure_image_edges(JsonObject& part, const ClaimStudies& e) {
  const std::vector<double> middle = part.numbers("middle_columns", 2);
  Contrast contrast{{{}, {}}, {{}}};
  contrast.value[1].weight = -1.0;
  if (e.evidence.calibration)
    for (const DistortionCurve& curve : e.evidence.calibration->distortion) {
      std::array<double, 2> sums{}, counts{};
      for (std::size_t c = 0; c < curve.depth_residual_m.size(); ++c) {
        if (!std::isfinite(curve.depth_residual_m[c])) continue;
        const auto column = static_cast<double>(c);
        const std::size_t place = column < middle[0] || column > middle[1] ? 0 : 1;
        sums[place] += curve.depth_residual_m[c];
        counts[place] += 1.0;
      }
      for (auto* ratio : {&contrast.value[0], &contrast.value[1], &contrast.base[0]}) {
        const std::size_t place = ratio == &contrast.value[0] ? 0 : 1;
        ratio->numerator.push_back(sums[place]);
        ratio->denominator.push_back(counts[place]);
      }
    }
  if (contrast.value[0].numerator.empty()) return missing("results of the study calibration with a wall");
  return {.parts = {{"outer columns against the middle", "%", percent_of(contrast)}},
          .clusters = "sensor units"};
}

}  // namespace trilat
