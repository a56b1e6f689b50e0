// SPDX-License-Identifier: MIT
#include "pipeline/gate/judge_numbers.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/gate/found_results.h"

namespace trilat {
namespace {

Json value_at(const Json& document, const Json::json_pointer& place) {
  return document.contains(place) ? document.at(place) : Json();
}

// The pointer, with the texts of the entry that it leads into: "/cells/0/mae_m (linear, standing)".
std::string named(const Json& document, Json::json_pointer place) {
  const std::string pointer = place.to_string();
  while (!place.empty()) {
    place.pop_back();
    std::string name;
    if (const Json entry = value_at(document, place); !place.empty() && entry.is_object())
      for (const auto& [key, value] : entry.items())
        if (value.is_string()) name += (name.empty() ? "" : ", ") + value.get<std::string>();
    if (!name.empty()) return fmt::format("{} ({})", pointer, name);
  }
  return pointer;
}

double percent_of(double now, double before) {
  return before == 0.0 ? std::copysign(100.0, now) : 100.0 * (now - before) / std::abs(before);
}

double size_of(const GateFinding& f) { return std::isnan(f.percent) ? HUGE_VAL : std::abs(f.percent); }

}  // namespace

NumberChanges judge_numbers(const std::string& study, const Json& now, const Json& before,
                            const GateLimits& limits) {
  NumberChanges changes;
  for (const Json& step : Json::diff(before, now)) {
    const Json::json_pointer place(step.at("path").get<std::string>());
    const Json here = value_at(now, place), there = value_at(before, place);
    ++changes.differing;
    GateFinding finding;
    finding.kind = FindingKind::number;
    finding.alarm = true;
    finding.study = study;
    finding.what = named(now, place);
    finding.chance = 0.0;
    if (here.is_number()) finding.now = here.get<double>();
    if (there.is_number()) finding.before = there.get<double>();
    if (here.is_number() && there.is_number()) {
      finding.percent = percent_of(finding.now, finding.before);
      changes.largest_percent = std::max(changes.largest_percent, std::abs(finding.percent));
      if (std::abs(finding.percent) <= limits.smallest_percent) continue;
    } else {
      finding.note = fmt::format("{} before, {} now", shortened(there), shortened(here));
    }
    changes.findings.push_back(std::move(finding));
  }
  std::stable_sort(changes.findings.begin(), changes.findings.end(),
                   [](const GateFinding& a, const GateFinding& b) { return size_of(a) > size_of(b); });
  if (changes.findings.size() > kMostNumbers) changes.findings.resize(kMostNumbers);
  return changes;
}

}  // namespace trilat
