// SPDX-License-Identifier: MIT
// Statistics of accuracy studies, with participants as clusters.
#include "pipeline/claims/measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace trilat {
namespace {

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
                                 Statistic{"speed", measure_speed},
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

namespace {

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

bool answers(const ParticipantErrors& errors, const std::string& name, const std::string& condition,
             const std::vector<std::string>& groups) {
  return std::ranges::all_of(groups, [&](const std::string& group) {
    return std::ranges::any_of(errors.error_m(name, condition, group).denominator,
                               [](double n) { return n > 0.0; });
  });
}

std::string silence_of(const std::string& name, const ParticipantErrors& errors) {
  return fmt::format("{} answers nothing on the rig of {}", name, errors.summary().campaign);
}

}  // namespace

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
      for (const std::string& name : {of, against})
        if (!answers(errors, name, condition, joints)) return missing(silence_of(name, errors));
      found.complete =
          percent_of(errors.difference(of, against, condition, joints, ComparedSamples::complete));
      if (const std::string& reference = errors.summary().reference; of == reference || against == reference)
        found.estimate = percent_of(errors.difference(of, against, condition, joints, ComparedSamples::both));
      else
        std::swap(found.estimate, *found.complete);  // compared by way of the reference
      if (!std::isfinite(found.estimate.value))
        return missing(fmt::format("{} and {} never answer the same sample", of, against));
      if (!std::isfinite(found.complete->value)) found.complete.reset();
      measured.parts.push_back(std::move(found));
    }
  }
  return measured.parts.empty() ? missing(fmt::format("{} with {} and {}", study_name(part), of, against))
                                : measured;
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
      if (!std::isfinite(found.estimate.value)) return missing(silence_of(method, errors));
      if (!std::isfinite(found.complete->value)) found.complete.reset();
      measured.parts.push_back(std::move(found));
    }
  }
  return measured.parts.empty() ? missing(fmt::format("{} with {}", study_name(part), method)) : measured;
}

// A method's error in the faster half of each joint's samples, against that in the slower one.
MeasuredPart measure_speed(JsonObject& part, const ClaimStudies& e) {
  const std::string method = part.text("method"), condition = part.text("condition", "walking");
  MeasuredPart measured;
  for (const ParticipantErrors& errors : studies_of(part, e)) {
    const std::vector<std::string> groups = errors.groups_of(condition);
    if (!errors.knows(method) || groups.empty()) continue;
    Contrast contrast;
    for (const std::string& group : groups)
      for (const bool fast : {true, false}) {
        WeightedRatio ratio = errors.speed_error_m(method, condition, group, fast);
        ratio.weight = (fast ? 1.0 : -1.0) / static_cast<double>(groups.size());
        contrast.value.push_back(ratio);
        if (fast) continue;
        ratio.weight = -ratio.weight;
        contrast.base.push_back(std::move(ratio));
      }
    Measurement found;
    found.what = fmt::format("{}: the faster half of each joint's samples against the slower one", method);
    found.unit = "%";
    found.estimate = percent_of(contrast);
    if (!std::isfinite(found.estimate.value)) return missing(silence_of(method, errors));
    measured.parts.push_back(std::move(found));
  }
  return measured.parts.empty() ? missing(fmt::format("{} with {}", study_name(part), method)) : measured;
}

// What a clock error costs at the fastest joints: the way they go in that time, in percent of a method's
// error.
MeasuredPart measure_clock_cost(JsonObject& part, const ClaimStudies& e) {
  const std::string method = part.text("method"), condition = part.text("condition", "walking");
  const double clock_s = part.number("clock_s");
  for (const ParticipantErrors& errors : studies_of(part, e)) {
    const TruthSpeed* fastest = nullptr;
    for (const TruthSpeed& speed : errors.summary().truth_speed)
      if (speed.condition == condition && (!fastest || speed.mean_m_s > fastest->mean_m_s)) fastest = &speed;
    if (!fastest || !errors.knows(method)) continue;
    Contrast contrast;
    contrast.base = {errors.error_m(method, condition, fastest->group)};
    WeightedRatio way = contrast.base.front();
    for (std::size_t p = 0; p < way.numerator.size(); ++p)
      way.numerator[p] = clock_s * fastest->mean_m_s * way.denominator[p];
    contrast.value = {way};
    Measurement found;
    found.what = fmt::format("{:g} ms at {:.2f} m/s against the error of {}, {}", 1e3 * clock_s,
                             fastest->mean_m_s, method, fastest->group);
    found.unit = "%";
    found.estimate = percent_of(contrast);
    return {.parts = {found}};
  }
  return missing(study_name(part));
}

}  // namespace trilat
