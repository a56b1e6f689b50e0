// SPDX-License-Identifier: MIT
#include "pipeline/gate/compare_results.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/results/gate_history.h"
#include "evaluators/metrics/statistics.h"
#include "pipeline/errors/error_changes.h"
#include "pipeline/gate/found_results.h"

namespace trilat {
namespace {

// What a summary of another kind than accuracy says of its recordings and numbers.
struct OtherSummary {
  static constexpr bool kHasMore = true;
  std::vector<std::string> failed;
  std::uint64_t rows = 0;

  static void fields(auto& self, auto&& f) {
    f("failed", self.failed, kMayLack);
    f("rows", self.rows);
  }
};

constexpr std::uint64_t kMinLost = 15;  // samples of a take: the loss of fewer says nothing

// Whether a length grew or fell by more than the limits.
bool is_change(double now_m, double before_m, const GateLimits& limits) {
  const double off_m = std::abs(now_m - before_m);
  return off_m > limits.smallest_m && 100.0 * off_m > limits.smallest_percent * std::abs(before_m);
}

// The answers (samples) and summed error lengths (m) of one cell, or of one take in it, in both results.
// Lengths are of the samples that both answer, where these are known.
struct BothSums {
  std::uint64_t answered_before = 0, answered_now = 0;
  std::uint64_t compared_before = 0, compared_now = 0;
  double length_before_m = 0.0, length_now_m = 0.0;

  void add(const TakeJointRow& before, const TakeJointRow& now, const CommonErrors* common) {
    answered_before += before.answered;
    answered_now += now.answered;
    compared_before += common ? common->samples : before.answered;
    compared_now += common ? common->samples : now.answered;
    if (common) {
      length_before_m += common->before_m;
      length_now_m += common->now_m;
      return;
    }
    if (before.answered > 0) length_before_m += static_cast<double>(before.answered) * before.mae_m;
    if (now.answered > 0) length_now_m += static_cast<double>(now.answered) * now.mae_m;
  }
  double before_m() const {
    return compared_before == 0 ? kNaN : length_before_m / static_cast<double>(compared_before);
  }
  double now_m() const { return compared_now == 0 ? kNaN : length_now_m / static_cast<double>(compared_now); }
};

// Takes of which a method answers other samples now.
std::set<std::string> takes_answered_otherwise(const ErrorsByJoint& before, const ErrorsByJoint& now) {
  std::map<std::tuple<std::string, std::string, std::string, std::string>, std::uint64_t> answered;
  for (const TakeJointRow& row : before.rows)
    answered[{row.take, row.condition, row.joint, row.method}] = row.answered;
  std::set<std::string> takes;
  for (const TakeJointRow& row : now.rows) {
    const auto found = answered.find({row.take, row.condition, row.joint, row.method});
    if (found != answered.end() && found->second != row.answered) takes.insert(row.take);
  }
  return takes;
}

// The rows of both results that are of the same take, condition, joint and method.
class SameTakes {
 public:
  SameTakes(const ErrorsByJoint& before, const ErrorsByJoint& now, const std::vector<std::string>& same,
            const CommonErrorsOfRows& common) {
    std::map<std::tuple<std::string, std::string, std::string, std::string>, const TakeJointRow*> known;
    for (const TakeJointRow& row : before.rows)
      known[{row.take, row.condition, row.joint, row.method}] = &row;
    const std::set<std::string> wanted(same.begin(), same.end());
    for (const TakeJointRow& row : now.rows) {
      const auto found = known.find({row.take, row.condition, row.joint, row.method});
      if (found == known.end() || !wanted.contains(row.take)) continue;
      const CellKey key{row.condition, row.method, row.group};
      if (!cells_.contains(key)) order_.push_back(key);
      const auto both = common.find({row.take, row.joint, row.method});
      const bool is_other = found->second->answered != row.answered;
      const CommonErrors* const errors = is_other && both != common.end() ? &both->second : nullptr;
      cells_[key].add(*found->second, row, errors);
      takes_[key][row.take].add(*found->second, row, errors);
    }
  }
  struct CellKey {
    std::string condition, method, group;
    auto operator<=>(const CellKey&) const = default;
  };
  const std::vector<CellKey>& order() const { return order_; }
  const BothSums& cell(const CellKey& key) const { return cells_.at(key); }
  const std::map<std::string, BothSums>& takes(const CellKey& key) const { return takes_.at(key); }

 private:
  std::vector<CellKey> order_;
  std::map<CellKey, BothSums> cells_;
  std::map<CellKey, std::map<std::string, BothSums>> takes_;
};

// The change of a mean error, whose direction and alarm are the caller's.
GateFinding accuracy_finding(const CellName& cell, double before_m, double now_m) {
  GateFinding finding = finding_of(cell, FindingKind::accuracy, Direction::changed, false);
  finding.what = "mean absolute error";
  finding.unit = "m";
  finding.before = before_m;
  finding.now = now_m;
  finding.percent = percent_of(now_m, before_m);
  return finding;
}

void add_accuracy(const CellName& cell, double before_m, double now_m, const GateLimits& limits,
                  GateReport& report) {
  ++report.looked_at;
  if (is_same(before_m, now_m)) return;
  const bool is_lost = std::isnan(before_m) || std::isnan(now_m);  // which its answers say
  if (!is_lost && !is_change(now_m, before_m, limits)) {
    ++report.within_limits;
    return;
  }
  GateFinding& finding = report.findings.emplace_back(accuracy_finding(cell, before_m, now_m));
  if (is_lost) return;
  finding.direction = now_m > before_m ? Direction::worse : Direction::better;
  finding.alarm = finding.direction == Direction::worse;
}

// The take that lost the largest share of its answers; nothing when none lost enough.
const std::pair<const std::string, BothSums>* worst_take(const std::map<std::string, BothSums>& takes,
                                                         const GateLimits& limits) {
  const auto share = [](const BothSums& sums) {
    return sums.answered_before == 0
               ? 0.0
               : 1.0 - static_cast<double>(sums.answered_now) / static_cast<double>(sums.answered_before);
  };
  const auto worst = std::ranges::max_element(
      takes, [&](const auto& a, const auto& b) { return share(a.second) < share(b.second); });
  if (worst == takes.end()) return nullptr;
  const BothSums& sums = worst->second;
  const bool enough = sums.answered_before >= sums.answered_now + kMinLost;
  return enough && 100.0 * share(sums) >= limits.take_loss_percent ? &*worst : nullptr;
}

void add_coverage(const CellName& name, const BothSums& cell, const std::map<std::string, BothSums>& takes,
                  const GateLimits& limits, GateReport& report) {
  const auto* worst = worst_take(takes, limits);
  if (cell.answered_before == cell.answered_now && !worst) return;
  const double percent =
      percent_of(static_cast<double>(cell.answered_now), static_cast<double>(cell.answered_before));
  const bool fell = worst || percent < -limits.smallest_loss_percent;
  const bool rose = !fell && (std::isnan(percent) || percent > limits.smallest_loss_percent);
  if (!fell && !rose) {
    ++report.within_limits;
    return;
  }
  GateFinding finding =
      finding_of(name, FindingKind::coverage, fell ? Direction::worse : Direction::better, fell);
  finding.what = "samples answered";
  finding.before = static_cast<double>(cell.answered_before);
  finding.now = static_cast<double>(cell.answered_now);
  finding.percent = percent;
  if (worst)
    finding.note = fmt::format("take {}: {} of {} left", worst->first, worst->second.answered_now,
                               worst->second.answered_before);
  report.findings.push_back(std::move(finding));
}

// The errors of these takes alone.
ErrorsByJoint errors_of(ErrorsByJoint errors, const std::vector<std::string>& takes) {
  std::erase_if(errors.rows,
                [&](const TakeJointRow& row) { return std::ranges::find(takes, row.take) == takes.end(); });
  return errors;
}

// Alarms, where both are not the same.
void add_failure(const std::string& study, const std::string& what, double before, double now,
                 const std::string& note, GateReport& report) {
  GateFinding finding = finding_of({study, "", "", ""}, FindingKind::failure, Direction::worse, true);
  finding.what = what;
  finding.before = before;
  finding.now = now;
  finding.note = note;
  report.findings.push_back(std::move(finding));
}

void compare_failures(const std::string& study, const ResultsSummary& before, const ResultsSummary& now,
                      GateReport& report) {
  std::set<std::string> known;
  for (const TakeNote& note : before.notes)
    if (note.failed) known.insert(note.take);
  std::string fresh;
  for (const TakeNote& note : now.notes)
    if (note.failed && !known.contains(note.take))
      fresh += (fresh.empty() ? "" : "; ") + note.take + " (" + note.place + ": " + note.text + ")";
  if (!fresh.empty() || now.takes_failed > before.takes_failed)
    add_failure(study, "takes that could not be evaluated", static_cast<double>(before.takes_failed),
                static_cast<double>(now.takes_failed), fresh, report);
  for (const CrossCheck& check : now.cross_checks) {
    const auto earlier = std::ranges::find(before.cross_checks, check.method, &CrossCheck::method);
    const bool was_there = earlier != before.cross_checks.end();
    if (check.passed() || (was_there && !earlier->passed())) continue;
    add_failure(study, "the cross-check of " + check.method + " with Ceres fails",
                was_there ? earlier->worst_m : kNaN, check.worst_m,
                check.samples == 0 ? "nothing was compared" : "worst at " + check.worst_at, report);
  }
}

class Comparison {
 public:
  explicit Comparison(const GateLimits& limits) : limits_(limits) {}

  void compare(const ResultsPair& pair) {
    StudyVerdict verdict{pair.now.name, name_of(pair.now.kind), StudyState::compared, {}, "", 0};
    if (pair.now.kind != pair.before.kind) {
      add_failure(pair.now.name, "is a study of another kind", kNaN, kNaN,
                  name_of(pair.before.kind) + " before, " + name_of(pair.now.kind) + " now", report_);
    } else if (pair.now.summary == pair.before.summary && pair.now.numbers == pair.before.numbers) {
      verdict.state = StudyState::identical;
      report_.looked_at += pair.now.summary.size();
    } else {
      verdict.settings = settings_that_differ(pair);
      if (pair.now.kind == StudyKind::accuracy)
        compare_accuracy(pair, verdict);
      else
        compare_other_kind(pair, verdict);
    }
    report_.studies.push_back(std::move(verdict));
  }

  void add_one_sided(const PairedSet& set, bool all_expected) {
    for (const std::string& name : set.only_now)
      report_.studies.push_back({name, "", StudyState::only_now, {}, "", 0});
    for (const std::string& name : set.only_before) {
      report_.studies.push_back({name, "", StudyState::only_before, {}, "", 0});
      if (all_expected)
        add_failure(name, "the study is in the baseline and not in these results", 1, 0, "", report_);
    }
  }

  GateReport finish() {
    judge_chances(limits_, report_);
    sort_findings(report_.findings);
    if (report_.within_limits > 0)
      report_.notes.push_back(
          fmt::format("numbers that changed by less than their limits: {}", report_.within_limits));
    return std::move(report_);
  }

 private:
  void compare_accuracy(const ResultsPair& pair, StudyVerdict& verdict) {
    const ResultsSummary now = read_results<ResultsSummary>(pair.now.folder),
                         before = read_results<ResultsSummary>(pair.before.folder);
    compare_failures(pair.now.name, before, now, report_);
    if (!are_comparable(before, now)) {
      add_failure(pair.now.name, "errors are measured in another way", kNaN, kNaN,
                  fmt::format("alignment {} against {} before, {} against {} now", before.alignments.front(),
                              before.truth, now.alignments.front(), now.truth),
                  report_);
      return;
    }
    add_one_sided_methods(before, now, verdict);
    const ErrorsByJoint errors_now = errors_by_joint(now), errors_before = errors_by_joint(before);
    const TakesOfBoth takes = takes_of_both(pair);
    const auto add_note = [&](const std::string& text) {
      verdict.note += (verdict.note.empty() ? "" : "; ") + text;
    };
    if (!takes.one_sided.empty())
      add_note(fmt::format("{} take{} only one side has, {}", takes.one_sided.size(),
                           takes.one_sided.size() == 1 ? " that" : "s that", takes.one_sided.front()));
    if (!takes.same.empty()) {
      const std::set<std::string> otherwise = takes_answered_otherwise(errors_before, errors_now);
      const CommonErrorsOfRows common = common_errors(pair.before.folder, pair.now.folder, otherwise);
      if (!otherwise.empty() && common.empty())
        add_note(
            "answers differ, and one side keeps no samples, or sensors are left out: errors are of what each "
            "side answers");
      compare_takes(pair.now.name, errors_before, errors_now, takes.same, limits_, report_, common);
    }
    if (!takes.other.empty())
      add_note(fmt::format("other recordings of {} take{}, {}", takes.other.size(),
                           takes.other.size() == 1 ? "" : "s", takes.other.front()));
    if (!takes.other.empty() || takes.same.empty()) {
      compare_others(pair.now.name,
                     takes.same.empty() ? errors_before : errors_of(errors_before, takes.other),
                     takes.same.empty() ? errors_now : errors_of(errors_now, takes.other), verdict, add_note);
    } else {
      compare_numbers(pair.now.name, before.numbers, now.numbers, NumberRule::list_rest, limits_, report_);
    }
  }

  void compare_other_kind(const ResultsPair& pair, StudyVerdict& verdict) {
    const auto summary = [](const FoundResults& found) {
      return read_as<OtherSummary>(found.summary, {found.folder / "summary.json"});
    };
    const auto numbers = [&](const FoundResults& found) {
      return read_numbers(found.folder, summary(found).rows);
    };
    const std::vector<std::string> before = summary(pair.before).failed, now = summary(pair.now).failed;
    std::vector<std::string> fresh;
    std::ranges::copy_if(now, std::back_inserter(fresh), [&](const std::string& text) {
      return std::ranges::find(before, text) == before.end();
    });
    if (!fresh.empty())
      add_failure(pair.now.name, "recordings that could not be evaluated", static_cast<double>(before.size()),
                  static_cast<double>(now.size()), fmt::format("{}", fmt::join(fresh, "; ")), report_);
    const TakesOfBoth recordings = takes_of_both(pair);
    const bool are_others = !recordings.other.empty() || !recordings.one_sided.empty();
    if (are_others) {
      verdict.state = StudyState::not_judged;
      verdict.note =
          fmt::format("other recordings, {}",
                      (recordings.other.empty() ? recordings.one_sided : recordings.other).front());
    }
    compare_numbers(pair.now.name, numbers(pair.before), numbers(pair.now),
                    are_others ? NumberRule::list : NumberRule::judge, limits_, report_);
  }

  // Judges takes of other recordings between participants; not judged where these are too few.
  void compare_others(const std::string& study, const ErrorsByJoint& before, const ErrorsByJoint& now,
                      StudyVerdict& verdict, const auto& add_note) {
    const std::size_t participants = std::min(participants_of(before).size(), participants_of(now).size());
    if (participants < kMinJudged) {
      verdict.state = StudyState::not_judged;
      verdict.participants = participants;
      add_note(
          fmt::format("the fewest that can be judged with other recordings are {} participants", kMinJudged));
      return;
    }
    const double found_percent = compare_people(study, before, now, limits_, report_);
    if (std::isfinite(found_percent))
      add_note(
          fmt::format("judged between {} participants: a method's average that is {:.0f} % worse would be "
                      "found in 95 of 100 nights",
                      participants, std::ceil(found_percent)));
  }

  static void add_one_sided_methods(const ResultsSummary& before, const ResultsSummary& now,
                                    StudyVerdict& verdict) {
    const auto only = [&](const std::vector<std::string>& here, const std::vector<std::string>& there,
                          const char* where) {
      std::vector<std::string> names;
      std::ranges::copy_if(here, std::back_inserter(names), [&](const std::string& name) {
        return std::ranges::find(there, name) == there.end();
      });
      if (!names.empty())
        verdict.settings.push_back(fmt::format("methods {} alone: {}", where, fmt::join(names, ", ")));
    };
    only(now.methods, before.methods, "of these results");
    only(before.methods, now.methods, "of the baseline");
  }

  const GateLimits& limits_;
  GateReport report_;
};

}  // namespace

namespace {

// "average without wrist".
std::string group_text(const std::string& group, const std::vector<std::string>& without) {
  return without.empty() ? group : fmt::format("{} without {}", group, fmt::join(without, ", "));
}

}  // namespace

void compare_takes(const std::string& study, const ErrorsByJoint& before, const ErrorsByJoint& now,
                   const std::vector<std::string>& same, const GateLimits& limits, GateReport& report,
                   const CommonErrorsOfRows& common) {
  const SameTakes both(before, now, same, common);
  struct Average {
    double before_m = 0.0, now_m = 0.0, groups = 0.0;
    std::vector<std::string> without;  // groups that one of both nights does not answer
  };
  std::map<std::pair<std::string, std::string>, Average> averages;  // by condition and method
  for (const SameTakes::CellKey& key : both.order()) {
    const BothSums& sums = both.cell(key);
    const CellName cell{study, key.method, key.condition, key.group};
    add_accuracy(cell, sums.before_m(), sums.now_m(), limits, report);
    add_coverage(cell, sums, both.takes(key), limits, report);
    Average& average = averages[{key.condition, key.method}];
    if (!std::isfinite(sums.before_m() + sums.now_m())) {
      average.without.push_back(key.group);
      continue;
    }
    average.before_m += sums.before_m();
    average.now_m += sums.now_m();
    average.groups += 1.0;
  }
  for (const auto& [key, average] : averages)
    if (average.groups > 1.0)
      add_accuracy({study, key.second, key.first, group_text(kAverageGroup, average.without)},
                   average.before_m / average.groups, average.now_m / average.groups, limits, report);
}

double compare_people(const std::string& study, const ErrorsByJoint& before, const ErrorsByJoint& now,
                      const GateLimits& limits, GateReport& report) {
  constexpr double kPower = 0.95;
  const std::optional<ErrorChanges> changes = changes_between(before, now);
  if (!changes) return kNaN;
  std::vector<double> found_percent;
  const double level = limits.chance / static_cast<double>(changes->rows.size());
  for (const ErrorChange& row : changes->rows) {
    ++report.looked_at;
    if (is_same(row.before_m, row.after_m) || !std::isfinite(row.difference_m)) continue;
    if (row.degrees == 0) continue;
    const std::size_t degrees = row.degrees;
    const double reach = student_quantile(degrees, level) + student_quantile(degrees, 2.0 * (1.0 - kPower));
    if (row.group == kAverageGroup)
      found_percent.push_back(100.0 * reach * row.standard_error_m / row.before_m);
    GateFinding finding = accuracy_finding(
        {study, row.method, row.condition, group_text(row.group, row.without)}, row.before_m, row.after_m);
    finding.direction = row.difference_m > 0.0 ? Direction::worse : Direction::better;
    finding.low = 100.0 * row.low_m / row.before_m;
    finding.high = 100.0 * row.high_m / row.before_m;
    finding.chance = row.chance;
    finding.clusters = row.clusters;
    report.findings.push_back(std::move(finding));
  }
  if (found_percent.empty()) return kNaN;
  std::ranges::sort(found_percent);
  return found_percent[found_percent.size() / 2];
}

void judge_chances(const GateLimits& limits, GateReport& report) {
  std::vector<double> chances;
  for (const GateFinding& f : report.findings) chances.push_back(f.chance);
  const std::vector<double> adjusted = holm_adjusted(chances);
  for (std::size_t k = 0; k < chances.size(); ++k) {
    GateFinding& f = report.findings[k];
    if (std::isnan(f.chance)) continue;
    f.chance = adjusted[k];
    f.alarm =
        f.direction == Direction::worse && adjusted[k] <= limits.chance && is_change(f.now, f.before, limits);
  }
  std::erase_if(report.findings, [&](const GateFinding& f) {
    return !std::isnan(f.chance) && !(f.chance <= limits.chance && is_change(f.now, f.before, limits));
  });
}

GateReport compare_results(const std::filesystem::path& results, const std::filesystem::path& baseline,
                           const GateLimits& limits) {
  if (!std::filesystem::exists(baseline))
    throw InputError(baseline.string(),
                     "is not there; to begin with these results: --accept \"first baseline\"");
  ResultsSet now = find_results(results), before = find_results(baseline);
  const bool all_expected = !now.single && !before.single;
  const PairedSet set = pair_results(std::move(now), std::move(before));
  if (set.pairs.empty())
    throw InputError(baseline.string(), fmt::format("and {} have no study in common", results.string()));
  Comparison comparison(limits);
  for (const ResultsPair& pair : set.pairs) comparison.compare(pair);
  comparison.add_one_sided(set, all_expected);
  GateReport report = comparison.finish();
  report.results = results.string();
  report.baseline = baseline.string();
  report.smallest_percent = limits.smallest_percent;
  if (const auto accepted = read_beside<AcceptedBaseline>(baseline)) {
    report.baseline_time = accepted->time;
    report.baseline_reason = accepted->reason;
  }
  return report;
}

}  // namespace trilat
