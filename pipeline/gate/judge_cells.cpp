// SPDX-License-Identifier: MIT
#include "pipeline/gate/judge_cells.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "evaluators/metrics/student.h"
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

double size_of(const GateFinding& f) {
  return std::isnan(f.change.percent) ? HUGE_VAL : std::abs(f.change.percent);
}

}  // namespace

NumberChanges judge_numbers(const std::string& study, const Json& now, const Json& before,
                            const GateLimits& limits) {
  NumberChanges changes;
  for (const Json& step : Json::diff(before, now)) {
    const Json::json_pointer place(step.at("path").get<std::string>());
    // "/list/-" is where a new entry is appended
    const Json here = step.value("value", Json()), there = value_at(before, place);
    ++changes.differing;
    GateFinding finding;
    finding.kind = FindingKind::number;
    finding.alarm = true;
    finding.study = study;
    finding.what = named(now, place);
    finding.change.chance = 0.0;
    if (here.is_number()) finding.now = here.get<double>();
    if (there.is_number()) finding.before = there.get<double>();
    if (here.is_number() && there.is_number()) {
      const double percent = finding.change.percent = percent_of(finding.now, finding.before);
      changes.largest_percent = std::max(changes.largest_percent, std::abs(percent));
      if (std::abs(percent) <= limits.smallest_percent) continue;
    } else {
      finding.note = fmt::format("{} before, {} now", shortened(there), shortened(here));
    }
    changes.findings.push_back(std::move(finding));
  }
  std::ranges::stable_sort(
      changes.findings, [](const GateFinding& a, const GateFinding& b) { return size_of(a) > size_of(b); });
  if (changes.findings.size() > kMostNumbers) changes.findings.resize(kMostNumbers);
  return changes;
}

namespace {

// Fewer lost samples of a take than these say nothing.
constexpr std::uint64_t kFewestLost = 15;
// Of the night's chance; each is corrected by itself, so that what is looked at more hides nothing.
constexpr double kAccuracyShare = 0.5, kCoverageShare = 0.05, kStatusShare = 0.05;

// Few clusters: there is no interval. What changed by more than the smallest is an alarm all the same.
constexpr const char* kCannotBeJudged =
    "cannot be judged, but it changed: one cluster says nothing of chance; longer or more takes do";

GateFinding finding_of(const ComparedCell& cell, FindingKind kind, Direction direction,
                       const Change& change) {
  GateFinding finding;
  static_cast<CellName&>(finding) = cell;
  finding.kind = kind;
  finding.direction = direction;
  finding.alarm = direction == Direction::worse;
  finding.change = change;
  finding.clusters = cell.clusters;
  finding.n = cell.both;
  return finding;
}

GateFinding accuracy_finding(const ComparedCell& cell, const Change& change) {
  GateFinding finding = finding_of(cell, FindingKind::accuracy,
                                   change.percent > 0.0 ? Direction::worse : Direction::better, change);
  finding.what = "mean absolute error (m)";
  finding.unit = "m";
  finding.before = cell.before_m;
  finding.now = cell.now_m;
  if (std::isnan(change.chance)) finding.note = kCannotBeJudged;
  return finding;
}

GateFinding coverage_finding(const ComparedCell& cell, Direction direction, double chance) {
  const auto before = static_cast<double>(cell.answered_before), now = static_cast<double>(cell.answered_now);
  const double percent = before > 0.0 ? 100.0 * (now - before) / before : kNoNumber;
  GateFinding finding =
      finding_of(cell, FindingKind::coverage, direction, {percent, kNoNumber, kNoNumber, chance});
  finding.what = "samples answered";
  finding.before = before;
  finding.now = now;
  finding.n = cell.asked;
  finding.note = fmt::format("of {} asked, {} are not answered any more and {} are new", cell.asked,
                             cell.lost_samples, cell.gained_samples);
  if (now < before && !cell.worst_take.empty())
    finding.note += fmt::format("; most in take {}: {} of {} left", cell.worst_take,
                                cell.worst_take_answered_now, cell.worst_take_answered_before);
  return finding;
}

bool loses_a_take(const ComparedCell& cell, const GateLimits& limits) {
  const std::uint64_t before = cell.worst_take_answered_before, now = cell.worst_take_answered_now;
  return before >= now + kFewestLost &&
         100.0 * static_cast<double>(before - now) >= limits.take_loss_percent * static_cast<double>(before);
}

// Whether a change is larger than the smallest and more than chance, or too large to pass where nothing is
// known of chance.
bool is_change(const Change& c, double smallest, double alpha) {
  if (!(std::abs(c.percent) > smallest)) return false;
  return std::isnan(c.chance) || (c.chance <= alpha && (c.low > 0.0 || c.high < 0.0));
}

// One night's cells: which are judged for what, and the chances of all, corrected together.
class JudgedCells {
 public:
  JudgedCells(std::span<const ComparedCell> cells, const GateLimits& limits) : limits_(limits) {
    for (const ComparedCell& cell : cells) first_alignment_.try_emplace(cell.study, cell.alignment);
    std::vector<double> accuracy, coverage, clamped;
    for (const ComparedCell& cell : cells) {
      accuracy.push_back(cell.error.chance);
      coverage.push_back(judges_coverage(cell) ? cell.lost.chance : kNoNumber);
      clamped.push_back(judges_statuses(cell) ? cell.clamped.chance : kNoNumber);
    }
    accuracy_ = holm_adjusted(accuracy);
    coverage_ = holm_adjusted(coverage);
    clamped_ = holm_adjusted(clamped);
  }

  void judge(const ComparedCell& cell, std::size_t c, bool same_inputs,
             std::vector<GateFinding>& findings) const {
    if (const Change error = corrected(cell.error, accuracy_[c]);
        is_change(error, limits_.smallest_percent, kAccuracyShare * limits_.chance))
      findings.push_back(accuracy_finding(cell, error));
    if (judges_coverage(cell))
      judge_coverage(cell, corrected(cell.lost, coverage_[c]), same_inputs, findings);
    if (judges_statuses(cell)) judge_statuses(cell, corrected(cell.clamped, clamped_[c]), findings);
  }

 private:
  static Change corrected(Change change, double chance) {
    change.chance = chance;
    return change;
  }

  void judge_coverage(const ComparedCell& cell, const Change& lost, bool same_inputs,
                      std::vector<GateFinding>& findings) const {
    if (is_change(lost, limits_.smallest_loss_percent, kCoverageShare * limits_.chance)) {
      const bool fewer = cell.answered_now < cell.answered_before;
      findings.push_back(coverage_finding(cell, fewer ? Direction::worse : Direction::better, lost.chance));
      if (std::isnan(lost.chance)) findings.back().note += std::string("; ") + kCannotBeJudged;
    } else if (same_inputs && loses_a_take(cell, limits_)) {
      findings.push_back(coverage_finding(cell, Direction::worse, kNoNumber));
    }
  }

  void judge_statuses(const ComparedCell& cell, const Change& clamped,
                      std::vector<GateFinding>& findings) const {
    const bool judged = is_change(clamped, limits_.smallest_loss_percent, kStatusShare * limits_.chance);
    if (!judged && cell.moved_percent <= limits_.smallest_percent) return;
    GateFinding finding =
        judged ? finding_of(cell, FindingKind::status,
                            clamped.percent > 0.0 ? Direction::worse : Direction::better, clamped)
               : finding_of(cell, FindingKind::status, Direction::changed, {});
    finding.what =
        judged ? "share of the answers that are clamped (points)" : "statuses of the samples asked";
    if (judged && std::isnan(clamped.chance)) finding.note = std::string(kCannotBeJudged) + "; ";
    finding.note += cell.status_changes;
    if (!judged) finding.n = cell.asked;
    findings.push_back(finding);
  }

  bool is_first(const ComparedCell& cell) const { return cell.alignment == first_alignment_.at(cell.study); }
  bool judges_coverage(const ComparedCell& cell) const {
    return is_first(cell) && cell.lost_samples + cell.gained_samples > 0;
  }
  bool judges_statuses(const ComparedCell& cell) const {
    return is_first(cell) && !cell.status_changes.empty();
  }

  const GateLimits& limits_;
  std::map<std::string, std::string> first_alignment_;  // by study
  std::vector<double> accuracy_, coverage_, clamped_;   // chances, corrected
};

}  // namespace

std::vector<GateFinding> judge_cells(std::span<const ComparedCell> cells, const GateLimits& limits,
                                     const std::vector<std::string>& studies_with_same_inputs) {
  JudgedCells judged(cells, limits);
  std::vector<GateFinding> findings;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const bool same =
        std::ranges::find(studies_with_same_inputs, cells[c].study) != studies_with_same_inputs.end();
    judged.judge(cells[c], c, same, findings);
  }
  return findings;
}

}  // namespace trilat
