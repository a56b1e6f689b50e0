// SPDX-License-Identifier: MIT
// Numbers of studies that takes do not judge.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/gate/compare_results.h"
#include "pipeline/gate/found_results.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxListed = 100;  // of a study that are listed

// Keys whose change is not listed: bounds of intervals, and bookkeeping.
bool is_news(const std::string& key) {
  static const std::set<std::string> kNoNews{"mean_iterations", "p05_m",   "p25_m",      "p75_m",  "clusters",
                                             "significant",     "program", "created_by", "version"};
  return !kNoNews.contains(key) && key.find("_low") == std::string::npos &&
         key.find("_high") == std::string::npos && !key.starts_with("low") && !key.starts_with("high");
}

Json value_at(const Json& document, const Json::json_pointer& place) {
  return document.contains(place) ? document.at(place) : Json();
}

// Rows of lists by what names them, "linear, standing", instead of by their place: a row that only one side
// has shifts no other.
Json with_named_rows(const Json& document) {
  if (!document.is_structured()) return document;
  Json named = document.is_array() && !document.empty() ? Json::object() : Json(document.type());
  for (const auto& [key, value] : document.items()) {
    std::string name = key;
    if (document.is_array() && value.is_object()) {
      std::string texts;
      for (const auto& [of, text] : value.items())
        if (text.is_string()) texts += (texts.empty() ? "" : ", ") + text.get<std::string>();
      if (!texts.empty()) name = texts;
      for (int again = 2; named.contains(name); ++again) name = fmt::format("{} ({})", texts, again);
    }
    named[name] = with_named_rows(value);
  }
  return named;
}

// Whether a change of a number is listed where takes are judged by their own errors: not the mean error and
// the answers, which are judged, and no number that only says how sure another is.
bool is_listed(const Number& number) {
  static const std::set<std::string> kNotListed{
      "difference",   "relative_difference", "sd",  "lower_limit", "upper_limit",
      "mean_of_sets", "share_of_sets",       "p05", "p25",         "p75"};
  if (!number.take.empty() || kNotListed.contains(number.statistic)) return false;
  if (number.measure == "distance" && number.statistic == "mean") return false;
  return number.measure != "answered" && number.measure != "iterations";
}

std::string text_of(const NumberKey& key) {
  std::string text = key.measure + " " + key.statistic;
  for (const std::string& part : {key.method, key.condition, key.group, key.alignment})
    if (!part.empty()) text += ", " + part;
  return text;
}

void add_largest(const std::string& study, std::vector<GateFinding> findings, GateReport& report) {
  sort_findings(findings);
  if (findings.size() > kMaxListed) {
    report.notes.push_back(fmt::format("{}: {} numbers differ, of which the {} largest are listed", study,
                                       findings.size(), kMaxListed));
    findings.resize(kMaxListed);
  }
  std::ranges::move(findings, std::back_inserter(report.findings));
}

}  // namespace

void list_numbers(const std::string& study, const Numbers& before, const Numbers& now,
                  const GateLimits& limits, GateReport& report) {
  std::vector<GateFinding> findings;
  const auto add = [&](const Number& key, double before_value, double now_value) {
    if (!is_listed(key)) return;
    ++report.looked_at;
    if (is_same(before_value, now_value)) return;
    const double least = unit_of(key) == "m" ? limits.smallest_m : limits.smallest_number;
    const double off = std::abs(now_value - before_value);
    if (off <= least || 100.0 * off <= limits.smallest_percent * std::abs(before_value)) {
      ++report.within_limits;
      return;
    }
    GateFinding finding = finding_of({study, "", "", ""}, FindingKind::number, Direction::changed, false);
    finding.what = text_of(key);
    finding.unit = unit_of(key);
    finding.before = before_value;
    finding.now = now_value;
    finding.percent = std::abs(before_value) <= least ? kNoNumber : percent_of(now_value, before_value);
    findings.push_back(std::move(finding));
  };
  for (const Number& number : now.all()) add(number, before.value(number), number.value);
  for (const Number& number : before.all())
    if (!now.find(number)) add(number, number.value, kNoNumber);
  add_largest(study, std::move(findings), report);
}

void compare_numbers(const std::string& study, const Json& document_before, const Json& document_now,
                     bool alarm, const GateLimits& limits, GateReport& report) {
  const Json before = with_named_rows(document_before), now = with_named_rows(document_now);
  std::vector<GateFinding> findings;
  for (const Json& step : Json::diff(before, now)) {
    const Json::json_pointer place(step.at("path").get<std::string>());
    const Json here = step.value("value", Json()), there = value_at(before, place);
    ++report.looked_at;
    const std::string& key = place.back();
    if (!is_news(key)) continue;
    GateFinding finding = finding_of({study, "", "", ""}, FindingKind::number, Direction::changed, alarm);
    finding.what = place.to_string();
    if (here.is_number()) finding.now = here.get<double>();
    if (there.is_number()) finding.before = there.get<double>();
    if (here.is_number() && there.is_number()) {
      if (is_same(finding.now, finding.before)) continue;
      const double least = key.ends_with("_m") ? limits.smallest_m : limits.smallest_number;
      const double off = std::abs(finding.now - finding.before);
      if (off <= least || 100.0 * off <= limits.smallest_percent * std::abs(finding.before)) {
        ++report.within_limits;
        continue;
      }
      if (key.ends_with("_m")) finding.unit = "m";
      if (std::abs(finding.before) > least) finding.percent = percent_of(finding.now, finding.before);
    } else {
      finding.note = fmt::format("{} before, {} now", shortened(there), shortened(here));
    }
    findings.push_back(std::move(finding));
  }
  add_largest(study, std::move(findings), report);
}

}  // namespace trilat
