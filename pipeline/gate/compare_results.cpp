// SPDX-License-Identifier: MIT
#include "pipeline/gate/compare_results.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/results/gate_history.h"
#include "datasets/results/samples.h"
#include "datasets/results/summary.h"
#include "pipeline/gate/found_results.h"
#include "pipeline/gate/gate_report.h"
#include "pipeline/gate/judge_numbers.h"
#include "pipeline/gate/paired_cells.h"
#include "pipeline/gate/paired_samples.h"

namespace trilat {
namespace {

// Alarms before the rest, the worst of a study first; otherwise as they were.
void sort_findings(std::vector<GateFinding>& findings) {
  const auto size = [](const GateFinding& f) { return std::isnan(f.percent) ? 0.0 : std::abs(f.percent); };
  std::stable_sort(findings.begin(), findings.end(), [&](const GateFinding& a, const GateFinding& b) {
    if (a.alarm != b.alarm) return a.alarm;
    if (a.study != b.study || a.kind != b.kind) return false;
    return size(a) > size(b);
  });
}

bool same_file(const ResultsPair& pair, const char* name, const std::function<bool()>& stop_requested) {
  const auto here = pair.now.folder / name, there = pair.before.folder / name;
  if (std::filesystem::file_size(here) != std::filesystem::file_size(there)) return false;
  return hash_of_file(here, stop_requested) == hash_of_file(there, stop_requested);
}

// What the paired samples do not judge: how far the worst errors go, iterations, GDOP, whole bodies.
Json told_numbers(const Json& summary) {
  Json told = Json::object();
  for (const char* part : {"cells", "bodies"})
    if (summary.contains(part)) told[part] = summary.at(part);
  if (!told.contains("cells") || !told["cells"].is_array()) return told;
  for (Json& cell : told["cells"])
    for (const char* judged : {"mae_m", "axis_mae_m", "answered", "asked", "statuses"})
      if (cell.is_object()) cell.erase(judged);
  return told;
}

class Comparison {
 public:
  explicit Comparison(const CompareOptions& options) : options_(options) {}

  void compare(const ResultsPair& pair) {
    check_same_configuration(pair);
    StudyVerdict verdict{pair.now.name, name_of(pair.now.kind), StudyState::compared, ""};
    if (same_inputs(pair.now.manifest, pair.before.manifest))
      same_inputs_.push_back(pair.now.name);
    else
      verdict.note = "the simulated recordings themselves are others than the baseline's";
    if (pair.now.kind == StudyKind::accuracy)
      compare_accuracy(pair, verdict);
    else
      compare_numbers(pair, verdict);
    report_.studies.push_back(verdict);
  }

  void add_one_sided(const PairedSet& set, bool all_expected) {
    for (const std::string& name : set.only_now)
      report_.studies.push_back({name, "", StudyState::only_now, ""});
    for (const std::string& name : set.only_before) {
      report_.studies.push_back({name, "", StudyState::only_before, ""});
      if (all_expected) add_failure(name, "the study is in the baseline and not in these results", 1, 0);
    }
  }

  GateReport finish(const PairedSet& set) {
    report_.looked_at += report_.cells.size();
    auto judged = judge_cells(report_.cells, options_.limits, same_inputs_);
    std::move(judged.begin(), judged.end(), std::back_inserter(report_.findings));
    for (GateFinding& f : report_.findings) f.command = command_of(set, f);
    sort_findings(report_.findings);
    return std::move(report_);
  }

 private:
  static std::string command_of(const PairedSet& set, const GateFinding& f) {
    for (const ResultsPair& pair : set.pairs) {
      if (pair.now.name != f.study) continue;
      std::string command = "trilat gate " + shell_word(pair.now.folder.string()) + " --baseline " +
                            shell_word(pair.before.folder.string());
      return command + (f.method.empty() ? " --json" : " --method " + shell_word(f.method));
    }
    return "";
  }

  void add_failure(const std::string& study, const std::string& what, double before, double now,
                   const std::string& note = "") {
    GateFinding finding;
    finding.kind = FindingKind::failure;
    finding.direction = Direction::worse;
    finding.alarm = true;
    finding.study = study;
    finding.what = what;
    finding.before = before;
    finding.now = now;
    finding.note = note;
    report_.findings.push_back(finding);
  }

  void compare_failures(const ResultsPair& pair) {
    const ResultsSummary now = read_summary(pair.now.folder), before = read_summary(pair.before.folder);
    std::set<std::string> known;
    for (const TakeNote& note : before.notes)
      if (note.failed) known.insert(note.take);
    std::string fresh;
    for (const TakeNote& note : now.notes)
      if (note.failed && !known.contains(note.take))
        fresh += (fresh.empty() ? "" : "; ") + note.take + " (" + note.place + ": " + note.text + ")";
    if (!fresh.empty() || now.takes_failed > before.takes_failed)
      add_failure(pair.now.name, "takes that could not be evaluated",
                  static_cast<double>(before.takes_failed), static_cast<double>(now.takes_failed), fresh);
    if (now.cross_check && !now.cross_check->passed() &&
        (!before.cross_check || before.cross_check->passed()))
      add_failure(pair.now.name, "the cross-check with Ceres fails",
                  before.cross_check ? before.cross_check->worst_m : GateFinding::kNone,
                  now.cross_check->worst_m, "worst at " + now.cross_check->worst_at);
  }

  void compare_accuracy(const ResultsPair& pair, StudyVerdict& verdict) {
    for (const FoundResults* night : {&pair.now, &pair.before})
      SamplesFile::open(night->folder / "samples.h5");
    compare_failures(pair);
    report_.looked_at += pair.now.summary.value("cells", Json::array()).size();
    if (same_file(pair, "samples.h5", options_.stop_requested)) {
      verdict.state = StudyState::identical;
      compare_numbers(pair, verdict);
      return;
    }
    if (options_.stop_requested && options_.stop_requested()) throw Interrupted();
    const PairedSamples samples = read_paired_samples(pair);
    if (samples.takes_with_other_instants > 0)
      add_failure(pair.now.name, "takes with other instants, which cannot be paired", 0.0,
                  static_cast<double>(samples.takes_with_other_instants),
                  "the first is " + samples.first_with_other_instants);
    if (samples.truths_that_differ > 0)
      verdict.note += fmt::format("{}the truth itself differs in {} samples",
                                  verdict.note.empty() ? "" : "; ", samples.truths_that_differ);
    const bool same = same_inputs(pair.now.manifest, pair.before.manifest);
    auto cells = compared_cells(samples.study, {options_.resamples, same});
    if (cells.empty() && samples.takes_with_other_instants == 0) verdict.state = StudyState::same_values;
    if (!same) check_participants(cells, verdict);
    std::move(cells.begin(), cells.end(), std::back_inserter(report_.cells));
    tell_numbers(pair);
  }

  // Other recordings of few people differ by chance as much as a regression would.
  static void check_participants(const std::vector<ComparedCell>& cells, StudyVerdict& verdict) {
    const auto fewest = std::min_element(
        cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.clusters < b.clusters; });
    if (fewest == cells.end() || fewest->clusters >= kFewestParticipants) return;
    verdict.state = StudyState::not_judged;
    verdict.participants = fewest->clusters;
    verdict.note += fmt::format("; the fewest that can be judged with other recordings are {} participants",
                                kFewestParticipants);
  }

  // Told without an alarm: single numbers have no chance to be held against.
  void tell_numbers(const ResultsPair& pair) {
    auto told = judge_numbers(pair.now.name, told_numbers(pair.now.summary),
                              told_numbers(pair.before.summary), options_.limits);
    for (GateFinding& f : told.findings) {
      f.alarm = false;
      report_.findings.push_back(std::move(f));
    }
  }

  void compare_numbers(const ResultsPair& pair, StudyVerdict& verdict) {
    if (pair.now.summary == pair.before.summary) {
      verdict.state = StudyState::identical;
      return;
    }
    verdict.state = StudyState::compared;
    NumberChanges changes =
        judge_numbers(pair.now.name, pair.now.summary, pair.before.summary, options_.limits);
    report_.looked_at += changes.differing;
    verdict.note += fmt::format("{}{} values differ, the largest change is {:.2g} %",
                                verdict.note.empty() ? "" : "; ", changes.differing, changes.largest_percent);
    if (changes.findings.size() == kMostNumbers)
      verdict.note += fmt::format("; the {} largest are listed", kMostNumbers);
    std::move(changes.findings.begin(), changes.findings.end(), std::back_inserter(report_.findings));
  }

  const CompareOptions& options_;
  GateReport report_;
  std::vector<std::string> same_inputs_;  // studies
};

}  // namespace

GateReport compare_results(const std::filesystem::path& results, const std::filesystem::path& baseline,
                           const CompareOptions& options) {
  if (!std::filesystem::exists(baseline))
    throw InputError(baseline.string(),
                     "is not there; to begin with these results: --accept \"first baseline\"");
  ResultsSet now = find_results(results), before = find_results(baseline);
  const bool all_expected = !now.single && !before.single;
  const PairedSet set = pair_results(std::move(now), std::move(before));
  if (set.pairs.empty())
    throw InputError(baseline.string(), fmt::format("and {} have no study in common", results.string()));
  Comparison comparison(options);
  for (const ResultsPair& pair : set.pairs) comparison.compare(pair);
  comparison.add_one_sided(set, all_expected);
  GateReport report = comparison.finish(set);
  report.results = results.string();
  report.baseline = baseline.string();
  report.smallest_percent = options.limits.smallest_percent;
  if (const auto accepted = read_accepted(baseline)) {
    report.baseline_time = accepted->time;
    report.baseline_reason = accepted->reason;
  }
  return report;
}

}  // namespace trilat
