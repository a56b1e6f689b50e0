// SPDX-License-Identifier: MIT
#include "pipeline/claims/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "evaluators/metrics/student.h"
#include "pipeline/participant_errors.h"

namespace trilat {
namespace {

MeasuredPart missing(const std::string& what) { return {.missing = what}; }

ContrastEstimate scaled(ContrastEstimate e, double factor) {
  e.value *= factor;
  e.standard_error *= factor;
  return e;
}

ContrastEstimate percent_of(const Contrast& contrast) { return scaled(solve_contrast(contrast), 100.0); }

// The studies that a part is measured in: Table III, Table II, or those of two to eight sensors.
const std::vector<ParticipantErrors>& studies_of(JsonObject& part, const ClaimStudies& studies) {
  const std::size_t chosen = part.choice("study", {"table3", "table2", "sensors"}, 0);
  return chosen == 0 ? studies.walking : chosen == 1 ? studies.occluded : studies.sensor_counts;
}

std::string study_name(JsonObject& part) { return "results of the study " + part.text("study", "table3"); }

// "average" stands for all groups of the condition.
std::vector<std::string> groups_of(const ParticipantErrors& errors, const std::string& condition,
                                   const std::string& group) {
  return group == kAverageGroup ? errors.groups_of(condition) : std::vector{group};
}

// Two methods, families or "best of" one: (of - against) / against, a part for each joint group asked for.
MeasuredPart measure_errors(JsonObject& part, const ClaimStudies& e) {
  const std::string of = part.text("of"), against = part.text("against"),
                    condition = part.text("condition", "walking");
  const std::vector<std::string> groups = part.texts("groups", {kAverageGroup});
  MeasuredPart measured;
  const auto& studies = studies_of(part, e);
  for (const ParticipantErrors& errors : studies) {
    if (!errors.knows(of) || !errors.knows(against) || errors.groups_of(condition).empty()) continue;
    for (const std::string& group : groups) {
      const auto joints = groups_of(errors, condition, group);
      Measurement found;
      found.what = fmt::format("{} against {}{}{}", of, against, group == kAverageGroup ? "" : ", " + group,
                               studies.size() > 1 ? ", " + errors.summary().campaign : "");
      found.unit = "%";
      found.estimate = percent_of(errors.difference(of, against, condition, joints, ComparedSamples::both));
      found.complete =
          percent_of(errors.difference(of, against, condition, joints, ComparedSamples::complete));
      if (!std::isfinite(found.estimate.value)) std::swap(found.estimate, *found.complete);
      if (!std::isfinite(found.complete->value)) found.complete.reset();
      measured.parts.push_back(std::move(found));
    }
  }
  return measured.parts.empty() ? missing(fmt::format("{} with {} and {}", study_name(part), of, against))
                                : measured;
}

// One method's error at one place, a joint group or a condition, against that at others.
Contrast places(const ParticipantErrors& errors, const std::string& method, bool complete,
                const std::array<std::string, 2>& conditions,
                const std::array<std::vector<std::string>, 2>& groups) {
  Contrast contrast;
  for (const std::size_t side : {0u, 1u})
    for (const std::string& group : groups[side]) {
      WeightedRatio ratio = complete ? errors.complete_error_m(method, conditions[side], group)
                                     : errors.error_m(method, conditions[side], group);
      ratio.weight = (side == 0 ? 1.0 : -1.0) / static_cast<double>(groups[side].size());
      contrast.value.push_back(ratio);
      if (side == 0) continue;
      ratio.weight = -ratio.weight;
      contrast.base.push_back(std::move(ratio));
    }
  return contrast;
}

MeasuredPart measure_places(JsonObject& part, const ClaimStudies& e) {
  const std::string method = part.text("method"), condition = part.text("condition", "walking"),
                    against_condition = part.text("against_condition", condition),
                    group = part.text("group", kAverageGroup);
  const std::vector<std::string> against_groups = part.texts("against_groups", {kAverageGroup});
  MeasuredPart measured;
  for (const ParticipantErrors& errors : studies_of(part, e)) {
    if (!errors.knows(method) || errors.groups_of(condition).empty() ||
        errors.groups_of(against_condition).empty())
      continue;
    for (const std::string& against : against_groups) {
      const std::array conditions{condition, against_condition};
      const std::array groups{groups_of(errors, condition, group),
                              groups_of(errors, against_condition, against)};
      Measurement found;
      found.what = fmt::format("{}: {} against {}", method, group == kAverageGroup ? condition : group,
                               against == kAverageGroup ? against_condition : against);
      found.unit = "%";
      found.estimate = percent_of(places(errors, method, false, conditions, groups));
      found.complete = percent_of(places(errors, method, true, conditions, groups));
      if (!std::isfinite(found.complete->value)) found.complete.reset();
      measured.parts.push_back(std::move(found));
    }
  }
  return measured.parts.empty() ? missing(fmt::format("{} with {}", study_name(part), method)) : measured;
}

// What a clock error costs at the fastest joints: the way they go in that time, in percent of a method's
// error.
MeasuredPart measure_clock_cost(JsonObject& part, const ClaimStudies& e) {
  const std::string method = part.text("method"), condition = part.text("condition", "walking");
  const double clock_s = part.number("clock_s");
  for (const ParticipantErrors& errors : studies_of(part, e)) {
    const TruthFloor* fastest = nullptr;
    for (const TruthFloor& floor : errors.summary().truth_floor)
      if (floor.condition == condition && (!fastest || floor.mean_speed_m_s > fastest->mean_speed_m_s))
        fastest = &floor;
    if (!fastest || !errors.knows(method)) continue;
    Contrast contrast;
    contrast.base = {errors.error_m(method, condition, fastest->group)};
    WeightedRatio way = contrast.base.front();
    for (std::size_t p = 0; p < way.numerator.size(); ++p)
      way.numerator[p] = clock_s * fastest->mean_speed_m_s * way.denominator[p];
    contrast.value = {way};
    Measurement found;
    found.what = fmt::format("{:g} ms at {:.2f} m/s against the error of {}, {}", 1e3 * clock_s,
                             fastest->mean_speed_m_s, method, fastest->group);
    found.unit = "%";
    found.estimate = percent_of(contrast);
    return {.parts = {found}};
  }
  return missing(study_name(part));
}

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

// The audit of the paper has the numbers that contradict each other.
MeasuredPart measure_printed(JsonObject& part, const ClaimStudies&) {
  part.text("erratum");
  return {.contradicts = true};
}

MeasuredPart measure_nothing(JsonObject& part, const ClaimStudies&) { return missing(part.text("because")); }

struct Statistic {
  const char* name;
  MeasuredPart (*measure)(JsonObject&, const ClaimStudies&);
};
constexpr std::array kStatistics{Statistic{"errors", measure_errors},
                                 Statistic{"places", measure_places},
                                 Statistic{"clock_cost", measure_clock_cost},
                                 Statistic{"clock_share", measure_clock_share},
                                 Statistic{"queue", measure_queue},
                                 Statistic{"wand", measure_wand},
                                 Statistic{"image_edges", measure_image_edges},
                                 Statistic{"readings", measure_readings},
                                 Statistic{"printed", measure_printed},
                                 Statistic{"none", measure_nothing}};

}  // namespace

ClaimStudies::ClaimStudies(const PaperEvidence& of) : evidence(of) {
  if (of.walking) walking.emplace_back(*of.walking);
  if (of.occluded) occluded.emplace_back(*of.occluded);
  for (const ResultsSummary& study : of.sensor_counts) sensor_counts.emplace_back(study);
}

MeasuredPart measure(JsonObject& part, const ClaimStudies& studies) {
  std::vector<std::string> names;
  for (const Statistic& statistic : kStatistics) names.emplace_back(statistic.name);
  return kStatistics.at(part.choice("statistic", names)).measure(part, studies);
}

}  // namespace trilat
