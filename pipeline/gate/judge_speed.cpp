// SPDX-License-Identifier: MIT
#include "pipeline/gate/judge_speed.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "evaluators/metrics/holm.h"
#include "evaluators/metrics/ratio_change.h"

namespace trilat {
namespace {

constexpr RatioChangeOptions kRatios{0.25, 24, 400, 1};

struct Judged {
  std::string solver;
  RatioChange change;
  double chance = GateFinding::kNone;  // corrected
  std::uint64_t rounds = 0;
};

const SolverSpeed* find_solver(const SpeedFile& speed, const std::string& name) {
  for (const SolverSpeed& s : speed.solvers)
    if (s.solver == name) return &s;
  return nullptr;
}

std::vector<Judged> changes_of(const SpeedFile& now, const SpeedFile& before) {
  std::vector<Judged> all;
  std::vector<double> chances;
  for (const SolverSpeed& s : now.solvers) {
    const SolverSpeed* older = find_solver(before, s.solver);
    if (!older) continue;
    all.push_back({s.solver, solve_ratio_change(s.ratios, older->ratios, kRatios), GateFinding::kNone,
                   s.ratios.size()});
    chances.push_back(all.back().change.chance);
  }
  const auto adjusted = holm_adjusted(chances);
  for (std::size_t k = 0; k < all.size(); ++k) all[k].chance = adjusted[k];
  return all;
}

bool is_large(const Judged& j, double alpha) {
  const double smallest = kSmallestSpeed_percent / 100.0;
  return std::abs(j.change.change) > smallest && (j.change.low > 0.0 || j.change.high < 0.0) &&
         j.chance <= alpha;
}

GateFinding finding_of(const Judged& j) {
  GateFinding f;
  f.kind = FindingKind::speed;
  f.direction = j.change.change > 0.0 ? Direction::worse : Direction::better;
  f.study = "speed";
  f.method = j.solver;
  f.what = "time against the reference";
  f.before = j.change.before;
  f.now = j.change.now;
  f.percent = 100.0 * j.change.change;
  f.percent_low = 100.0 * j.change.low;
  f.percent_high = 100.0 * j.change.high;
  f.chance = j.chance;
  f.n = j.rounds;
  return f;
}

constexpr const char* kNotConfirmed = "not confirmed";

// Adds to each slower finding what another measurement says, which is nothing when it was disturbed; whether
// one is left that all confirm.
bool confirm(std::vector<GateFinding>& findings, const std::vector<Judged>& again, double alpha) {
  bool left = false;
  for (GateFinding& f : findings) {
    if (f.direction != Direction::worse || f.note.find(kNotConfirmed) != std::string::npos) continue;
    if (again.empty())
      f.note += fmt::format("{}disturbed, {}", f.note.empty() ? "measured again: " : ", ", kNotConfirmed);
    for (const Judged& j : again) {
      if (j.solver != f.method) continue;
      f.note +=
          fmt::format("{}{:+.1f} %", f.note.empty() ? "measured again: " : ", ", 100.0 * j.change.change);
      const bool confirmed = is_large(j, alpha) && j.change.change > 0.0;
      if (!confirmed) f.note += fmt::format(", {}", kNotConfirmed);
      left |= confirmed;
    }
  }
  return left;
}

}  // namespace

SpeedJudgement judge_speed(const SpeedFile& now, const SpeedFile& before, const GateLimits& limits,
                           const std::function<SpeedFile()>& measure_again) {
  SpeedJudgement result;
  if (now.processor != before.processor) {
    result.verdict.note = fmt::format("not judged: tonight's processor is \"{}\", the baseline's \"{}\"",
                                      now.processor, before.processor);
    return result;
  }
  if (now.reference != before.reference || now.problems != before.problems) {
    result.verdict.note = "not judged: the baseline was measured against another reference";
    return result;
  }
  result.verdict.judged = true;
  const double alpha = limits.chance / 2.0;
  bool slower = false;
  for (const Judged& j : changes_of(now, before))
    if (is_large(j, alpha)) {
      result.findings.push_back(finding_of(j));
      slower |= j.change.change > 0.0;
    }
  result.verdict.note =
      fmt::format("{} solvers, each against \"{}\" of the same run", now.solvers.size(), now.reference);
  const double busy = std::max(now.others_busy, before.others_busy);
  if (busy > kBusy)
    result.verdict.note +=
        fmt::format("; told only, no alarm: other programs kept {:.1f} processors busy", busy);
  if (!slower || busy > kBusy) return result;
  for (int rerun = 0; measure_again && rerun < kSpeedReruns; ++rerun) {
    result.verdict.rerun = true;
    const SpeedFile again = measure_again();
    const std::vector<Judged> changes =
        is_disturbed(again) ? std::vector<Judged>{} : changes_of(again, before);
    if (!confirm(result.findings, changes, alpha)) break;
  }
  for (GateFinding& f : result.findings) {
    if (f.direction != Direction::worse) continue;
    f.alarm = measure_again && f.note.find(kNotConfirmed) == std::string::npos;
    if (!measure_again) f.note = "not measured again (--speed does)";
  }
  return result;
}

}  // namespace trilat
