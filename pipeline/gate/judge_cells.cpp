// SPDX-License-Identifier: MIT
#include "pipeline/gate/judge_cells.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "evaluators/metrics/holm.h"

namespace trilat {
namespace {

// Fewer lost samples of a take than these say nothing.
constexpr std::uint64_t kFewestLost = 15;

GateFinding finding_of(const ComparedCell& cell, FindingKind kind, bool worse) {
  GateFinding finding;
  finding.kind = kind;
  finding.direction = worse ? Direction::worse : Direction::better;
  finding.alarm = worse;
  finding.study = cell.study;
  finding.method = cell.method;
  finding.condition = cell.condition;
  finding.group = cell.group;
  finding.alignment = cell.alignment;
  return finding;
}

// Whether an interval is on one side of no change.
bool leaves_zero_out(double low, double high) { return low > 0.0 || high < 0.0; }

GateFinding accuracy_finding(const ComparedCell& cell, double chance) {
  GateFinding finding = finding_of(cell, FindingKind::accuracy, cell.percent > 0.0);
  finding.what = "mean absolute error (m)";
  finding.before = cell.before_m;
  finding.now = cell.now_m;
  finding.percent = cell.percent;
  finding.percent_low = cell.percent_low;
  finding.percent_high = cell.percent_high;
  finding.chance = chance;
  finding.n = cell.both;
  finding.clusters = cell.clusters;
  return finding;
}

GateFinding coverage_finding(const ComparedCell& cell, double chance) {
  GateFinding finding = finding_of(cell, FindingKind::coverage, cell.answered_now < cell.answered_before);
  finding.what = "samples answered";
  finding.before = static_cast<double>(cell.answered_before);
  finding.now = static_cast<double>(cell.answered_now);
  finding.percent = 100.0 * (finding.now - finding.before) / finding.before;
  finding.chance = chance;
  finding.n = cell.asked;
  finding.clusters = cell.clusters;
  finding.note = fmt::format("of {} asked, {} are not answered any more and {} are new", cell.asked,
                             cell.lost, cell.gained);
  if (finding.direction == Direction::worse && !cell.worst_take.empty())
    finding.note += fmt::format("; most in take {}: {} of {} left", cell.worst_take,
                                cell.worst_take_answered_now, cell.worst_take_answered_before);
  return finding;
}

bool loses_a_take(const ComparedCell& cell, const GateLimits& limits) {
  const std::uint64_t before = cell.worst_take_answered_before, now = cell.worst_take_answered_now;
  return before >= now + kFewestLost &&
         100.0 * static_cast<double>(before - now) >= limits.take_loss_percent * static_cast<double>(before);
}

}  // namespace

std::vector<GateFinding> judge_cells(std::span<const ComparedCell> cells, const GateLimits& limits,
                                     const std::vector<std::string>& studies_with_same_inputs) {
  std::map<std::string, std::string> first_alignment;  // by study
  for (const ComparedCell& cell : cells) first_alignment.try_emplace(cell.study, cell.alignment);
  const auto judges_coverage = [&](const ComparedCell& cell) {
    return cell.alignment == first_alignment.at(cell.study) && cell.lost + cell.gained > 0;
  };
  std::vector<double> chances;
  for (const ComparedCell& cell : cells) {
    chances.push_back(cell.chance);
    chances.push_back(judges_coverage(cell) ? cell.lost_chance : GateFinding::kNone);
  }
  const std::vector<double> adjusted = holm_adjusted(chances);
  const double alpha = limits.chance / 2.0;
  std::vector<GateFinding> findings;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const ComparedCell& cell = cells[c];
    const double accuracy = adjusted[2 * c], coverage = adjusted[2 * c + 1];
    if (std::abs(cell.percent) > limits.smallest_percent && accuracy <= alpha &&
        leaves_zero_out(cell.percent_low, cell.percent_high))
      findings.push_back(accuracy_finding(cell, accuracy));
    if (!judges_coverage(cell)) continue;
    const bool same = std::find(studies_with_same_inputs.begin(), studies_with_same_inputs.end(),
                                cell.study) != studies_with_same_inputs.end();
    const bool all_over = std::abs(cell.lost_percent) > limits.smallest_loss_percent && coverage <= alpha &&
                          leaves_zero_out(cell.lost_low, cell.lost_high);
    if (all_over) {
      findings.push_back(coverage_finding(cell, coverage));
    } else if (same && loses_a_take(cell, limits)) {
      findings.push_back(coverage_finding(cell, GateFinding::kNone));
      findings.back().direction = Direction::worse;
      findings.back().alarm = true;
    }
  }
  return findings;
}

}  // namespace trilat
