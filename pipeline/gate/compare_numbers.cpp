// SPDX-License-Identifier: MIT
// Numbers that are not judged take by take.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include <fmt/format.h>

#include "pipeline/gate/compare_results.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxListed = 100;  // numbers of a study that are listed

// Whether a change of the number is news: it is of all takes, and does not only say how sure another number
// is.
bool is_news(const Number& number) {
  static const std::set<std::string> kNoNews{
      "difference",   "relative_difference", "sd",  "lower_limit", "upper_limit",
      "mean_of_sets", "share_of_sets",       "p05", "p25",         "p75"};
  return number.take.empty() && !kNoNews.contains(number.statistic) && number.measure != "iterations";
}

// The mean errors and answers of an accuracy study, which are judged take by take.
bool is_judged_by_take(const Number& number) {
  return number.measure == "answered" || (number.measure == "distance" && number.statistic == "mean");
}

std::string text_of(const NumberKey& key) {
  std::string text = key.measure + " " + key.statistic;
  for (const std::string& part : {key.method, key.condition, key.group, key.alignment})
    if (!part.empty()) text += ", " + part;
  return text;
}

Direction direction_of(const NumberKey& key, double before, double now) {
  const Better better = better_of(key);
  if (better == Better::neither || std::isnan(before + now)) return Direction::changed;
  return (now > before) == (better == Better::larger) ? Direction::better : Direction::worse;
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

void compare_numbers(const std::string& study, const Numbers& before, const Numbers& now, NumberRule rule,
                     const GateLimits& limits, GateReport& report) {
  std::vector<GateFinding> findings;
  const auto add = [&](const Number& key, double before_value, double now_value) {
    if (!is_news(key) || (rule == NumberRule::list_rest && is_judged_by_take(key))) return;
    ++report.looked_at;
    if (is_same(before_value, now_value)) return;
    const double least = unit_of(key) == "m" ? limits.smallest_m : limits.smallest_number;
    const double off = std::abs(now_value - before_value);
    if (off <= least || 100.0 * off <= limits.smallest_percent * std::abs(before_value)) {
      ++report.within_limits;
      return;
    }
    const Direction direction = direction_of(key, before_value, now_value);
    const bool is_gone = std::isnan(now_value) && better_of(key) != Better::neither;
    GateFinding finding = finding_of({study, "", "", ""}, FindingKind::number, direction,
                                     rule == NumberRule::judge && (is_gone || direction == Direction::worse));
    finding.what = text_of(key);
    finding.unit = unit_of(key);
    finding.before = before_value;
    finding.now = now_value;
    finding.percent = std::abs(before_value) <= least ? kNaN : percent_of(now_value, before_value);
    findings.push_back(std::move(finding));
  };
  for (const Number& number : now.all()) add(number, before.value(number), number.value);
  for (const Number& number : before.all())
    if (!now.find(number)) add(number, number.value, kNaN);
  add_largest(study, std::move(findings), report);
}

}  // namespace trilat
