// SPDX-License-Identifier: MIT
#include "pipeline/gate/compare_results.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/words.h"
#include "datasets/results/gate_history.h"
#include "pipeline/errors/error_changes.h"
#include "pipeline/gate/found_results.h"

namespace trilat {
namespace {

// Summary of another kind than accuracy, of its recordings and numbers.
struct OtherSummary {
  static constexpr bool kHasMore = true;
  std::vector<std::string> failed;
  std::uint64_t rows = 0;

  static void fields(auto& self, auto&& f) {
    f("failed", self.failed, kMayLack);
    f("rows", self.rows);
  }
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

  void add_one_sided(const MatchedStudies& set, bool all_expected) {
    for (const std::string& name : set.only_now)
      report_.studies.push_back({name, "", StudyState::only_now, {}, "", 0});
    for (const std::string& name : set.only_before) {
      report_.studies.push_back({name, "", StudyState::only_before, {}, "", 0});
      if (all_expected)
        add_failure(name, "the study is in the baseline and not in these results", 1, 0, "", report_);
    }
  }

  GateReport finish() {
    adjust_p_values(limits_, report_);
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
    const MatchedTakes takes = match_takes(pair);
    const auto add_note = [&](const std::string& text) {
      verdict.note += (verdict.note.empty() ? "" : "; ") + text;
    };
    if (!takes.one_sided.empty())
      add_note(fmt::format("{} that only one side has, {}", counted(takes.one_sided.size(), "take"),
                           takes.one_sided.front()));
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
      add_note(fmt::format("other recordings of {}, {}", counted(takes.other.size(), "take"),
                           takes.other.front()));
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
    const MatchedTakes recordings = match_takes(pair);
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
    const double found_percent = compare_unpaired(study, before, now, limits_, report_);
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

GateReport compare_results(const std::filesystem::path& results, const std::filesystem::path& baseline,
                           const GateLimits& limits) {
  if (!std::filesystem::exists(baseline))
    throw InputError(baseline.string(),
                     "is not there; to begin with these results: --accept \"first baseline\"");
  ResultsSet now = find_results(results), before = find_results(baseline);
  const bool all_expected = !now.single && !before.single;
  const MatchedStudies set = match_studies(std::move(now), std::move(before));
  if (set.pairs.empty())
    throw InputError(baseline.string(), fmt::format("and {} have no study in common", results.string()));
  Comparison comparison(limits);
  for (const ResultsPair& pair : set.pairs) comparison.compare(pair);
  comparison.add_one_sided(set, all_expected);
  GateReport report = comparison.finish();
  report.results = results.string();
  report.baseline = baseline.string();
  report.smallest_percent = limits.smallest_percent;
  if (const auto accepted = read_json_file<AcceptedBaseline>(baseline)) {
    report.baseline_time = accepted->time;
    report.baseline_reason = accepted->reason;
  }
  return report;
}

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
