// SPDX-License-Identifier: MIT
#include "pipeline/gate/compare_results.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/results/gate_history.h"
#include "datasets/results/item_store.h"
#include "datasets/results/summary.h"
#include "datasets/skeleton/skeleton.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/gate/found_results.h"
#include "pipeline/gate/gate_report.h"
#include "pipeline/gate/judge_cells.h"
#include "pipeline/gate/paired_cells.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

struct PairedSamples {
  PairedStudy study;
  std::uint64_t takes_with_other_instants = 0;  // cannot be paired and are left out
  std::string first_with_other_instants;
  std::uint64_t truths_that_differ = 0;  // samples, of those that both nights have a truth for
};

constexpr std::uint64_t kWindow = 512;  // instants that are read together

std::string names_of(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

// The takes of one night and what their samples have in common.
struct NightSamples {
  std::vector<ResultTake> takes;
  TakeHead head;
  std::string alignment;
  explicit NightSamples(const std::filesystem::path& results) : takes(result_takes(results)) {
    for (const ResultTake& take : takes) {
      if (take.folder.empty() || !head.joints.empty()) continue;
      const StoredTake file = open_take(take);
      head = file.head();
      alignment = file.read_errors().alignments.at(0);
    }
  }
};

void check_heads(const NightSamples& now, const NightSamples& before, const std::string& place) {
  const auto check = [&](const char* what, const std::string& here, const std::string& there) {
    if (here != there)
      throw InputError(place, fmt::format("holds other {}: {} here, {} there", what, there, here));
  };
  check("joints", names_of(now.head.joints), names_of(before.head.joints));
  check("methods", names_of(now.head.methods), names_of(before.head.methods));
  check("alignment", now.alignment, before.alignment);
  std::vector<std::string> ids, older;
  for (const ResultTake& take : now.takes) ids.push_back(take.id);
  for (const ResultTake& take : before.takes) older.push_back(take.id);
  check("takes", names_of(ids), names_of(older));
}

PairedStudy study_of(const ResultsPair& pair, const NightSamples& night) {
  PairedStudy study;
  const Json& spec = pair.now.manifest.at("study");
  study.study = pair.now.name;
  study.methods = night.head.methods;
  study.alignments = {night.alignment};
  const auto kinds = spec.value("alignments", std::vector<std::string>{});
  if (night.alignment != "none" && std::ranges::find(kinds, "none") != kinds.end())
    study.alignments.emplace_back("none");
  for (const std::string& name : night.head.joints) {
    const auto joint = joint_from_name(name);
    const std::string group = joint ? table_group(*joint) : name;
    auto found = std::ranges::find(study.groups, group);
    if (found == study.groups.end()) found = study.groups.insert(study.groups.end(), group);
    study.axes.group_of_joint.push_back(static_cast<std::size_t>(found - study.groups.begin()));
  }
  study.axes.alignments = study.alignments.size();
  study.axes.sets = spec.value("occluded_apart", false) ? 2 : 1;
  study.axes.groups = study.groups.size();
  study.axes.methods = study.methods.size();
  for (const ResultTake& take : night.takes)
    study.takes.push_back({take.id, take.id, take.condition, {}, {}});
  for (const Json& take : pair.now.manifest.value("takes", Json::array()))
    for (PairedTake& known : study.takes)
      if (known.id == take.value("id", "")) known.participant = take.value("participant", known.participant);
  return study;
}

// One night's take, and its samples as far as they are read.
struct Night {
  StoredTake file;
  std::vector<AlignmentRow> laid_over;  // by track, joint and method, under the first alignment
  SampleBlock block;

  explicit Night(const ResultTake& take) : file(open_take(take)) {
    const TakeHead& head = file.head();
    laid_over.resize(head.tracks.size() * head.joints.size() * head.methods.size());
    for (const AlignmentRow& row : file.read_errors().laid_over)
      if (row.alignment == 0) laid_over[row.quantity * head.methods.size() + row.method] = row;
  }
  Eigen::Map<const Eigen::Vector3d> truth_m(std::size_t place) const {
    return Eigen::Map<const Eigen::Vector3d>(&block.truth_m[3 * place]);
  }
  // Of instant i of the block, which is of that track.
  PairedAnswer answer(std::size_t track, std::uint64_t i, std::size_t place, std::size_t slot) const {
    const auto status = static_cast<SolveStatus>(block.status[slot]);
    const std::size_t of_track = laid_over.size() / file.head().tracks.size();
    const AlignmentRow& over = laid_over[track * of_track + slot % of_track];
    if (!is_usable(status) || block.first_instant + i < over.first_instant)
      return {{kNoNumber, kNoNumber}, status};
    const Eigen::Map<const Eigen::Vector3d> estimate_m(&block.estimate_m[3 * slot]);
    return {{(over.aligned_m(estimate_m, block.heading_rad[i]) - truth_m(place)).norm(),
             (estimate_m - truth_m(place)).norm()},
            status};
  }
};

struct TakeReader {
  const NightSamples& now;
  const NightSamples& before;
  const PairedAxes& axes;
  std::uint64_t block_instants;

  // False when the instants are not the same; then nothing is filled.
  bool read(std::size_t t, PairedTake& take, std::uint64_t& truths_that_differ) const {
    if (now.takes[t].folder.empty() || before.takes[t].folder.empty()) {  // told as a failure
      PairedTakeSums(axes, 0).finish(take);
      return true;
    }
    Night here(now.takes[t]), there(before.takes[t]);
    const std::uint64_t instants = here.file.head().instants;
    const std::size_t tracks = here.file.head().tracks.size();
    if (instants != there.file.head().instants || tracks != there.file.head().tracks.size()) return false;
    PairedTakeSums sums(axes, (instants + block_instants - 1) / block_instants);
    for (std::size_t track = 0; track < tracks; ++track)
      for (std::uint64_t first = 0; first < instants; first += kWindow) {
        const std::uint64_t count = std::min(kWindow, instants - first);
        for (Night* night : {&here, &there})
          night->file.read(track, first, count, SampleColumns::errors, night->block);
        if (here.block.time_ns != there.block.time_ns) return false;
        for (std::uint64_t i = 0; i < count; ++i)
          add_instant(here, there, track, first, i, sums, truths_that_differ);
      }
    sums.finish(take);
    return true;
  }

  void add_instant(const Night& here, const Night& there, std::size_t track, std::uint64_t first,
                   std::uint64_t i, PairedTakeSums& sums, std::uint64_t& truths_that_differ) const {
    for (std::size_t j = 0; j < axes.group_of_joint.size(); ++j) {
      const std::size_t place = i * axes.group_of_joint.size() + j;
      if (!here.truth_m(place).allFinite() || !there.truth_m(place).allFinite()) continue;
      truths_that_differ += here.truth_m(place) != there.truth_m(place);
      const std::size_t sets = axes.sets == 1 || there.block.occluded[place] == 0 ? 1 : 2;
      for (std::size_t m = 0; m < axes.methods; ++m) {
        const std::size_t slot = place * axes.methods + m;
        sums.add((first + i) / block_instants, j, m, sets, there.answer(track, i, place, slot),
                 here.answer(track, i, place, slot));
      }
    }
  }
};

// Streams both nights' samples side by side: the same take, instant, joint and method. InputError when
// they do not hold the same takes, joints and methods.
PairedSamples read_paired_samples(const ResultsPair& pair) try {
  const NightSamples now(pair.now.folder), before(pair.before.folder);
  check_heads(now, before, pair.before.folder.string());
  PairedSamples samples;
  samples.study = study_of(pair, now);
  const double rate_hz = pair.now.manifest.at("study").value("rate_hz", 30.0);
  const auto block = static_cast<std::uint64_t>(std::max(1LL, std::llround(kPairedBlock_s * rate_hz)));
  const TakeReader reader{now, before, samples.study.axes, block};
  std::vector<PairedTake>& takes = samples.study.takes;
  std::vector<std::uint8_t> paired(takes.size());
  std::vector<std::uint64_t> other_truths(takes.size());
  parallel_for_index(takes.size(), 1,
                     [&](std::size_t t) { paired[t] = reader.read(t, takes[t], other_truths[t]); });
  for (std::size_t t = 0; t < takes.size(); ++t) {
    samples.truths_that_differ += other_truths[t];
    if (paired[t]) continue;
    if (samples.takes_with_other_instants++ == 0) samples.first_with_other_instants = takes[t].id;
  }
  return samples;
} catch (const Json::exception& error) {
  throw InputError((pair.now.folder / "manifest.json").string(), error.what());
}

// Alarms before the rest, the worst of a study first; otherwise as they were.
void sort_findings(std::vector<GateFinding>& findings) {
  const auto size = [](const GateFinding& f) {
    return std::isnan(f.change.percent) ? 0.0 : std::abs(f.change.percent);
  };
  std::ranges::stable_sort(findings, [&](const GateFinding& a, const GateFinding& b) {
    if (a.alarm != b.alarm) return a.alarm;
    if (a.study != b.study || a.kind != b.kind) return false;
    return size(a) > size(b);
  });
}

bool same_samples(const ResultsPair& pair, const std::function<bool()>& stop_requested) {
  const auto now = result_takes(pair.now.folder), before = result_takes(pair.before.folder);
  return std::ranges::equal(now, before, [&](const ResultTake& here, const ResultTake& there) {
    if (here.id != there.id || here.folder.empty() != there.folder.empty()) return false;
    if (here.folder.empty()) return true;
    const auto a = here.folder / StoredTake::kName, b = there.folder / StoredTake::kName;
    return std::filesystem::file_size(a) == std::filesystem::file_size(b) &&
           hash_of_file(a, stop_requested) == hash_of_file(b, stop_requested);
  });
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
    for (const CrossCheck& check : now.cross_checks) {
      const auto earlier = std::ranges::find(before.cross_checks, check.method, &CrossCheck::method);
      const bool was_there = earlier != before.cross_checks.end();
      if (check.passed() || (was_there && !earlier->passed())) continue;
      add_failure(pair.now.name, "the cross-check of " + check.method + " with Ceres fails",
                  was_there ? earlier->worst_m : kNoNumber, check.worst_m,
                  check.samples == 0 ? "nothing was compared" : "worst at " + check.worst_at);
    }
  }

  void compare_accuracy(const ResultsPair& pair, StudyVerdict& verdict) {
    compare_failures(pair);
    report_.looked_at += pair.now.summary.value("cells", Json::array()).size();
    if (same_samples(pair, options_.stop_requested)) {
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
    auto cells = compared_cells(samples.study, {same});
    if (cells.empty() && samples.takes_with_other_instants == 0) verdict.state = StudyState::same_values;
    if (!same) check_participants(cells, verdict);
    std::move(cells.begin(), cells.end(), std::back_inserter(report_.cells));
    tell_numbers(pair);
  }

  // Other recordings of few people differ by chance as much as a regression would.
  static void check_participants(const std::vector<ComparedCell>& cells, StudyVerdict& verdict) {
    const auto fewest =
        std::ranges::min_element(cells, [](const auto& a, const auto& b) { return a.clusters < b.clusters; });
    if (fewest == cells.end() || fewest->clusters >= kFewestJudged) return;
    verdict.state = StudyState::not_judged;
    verdict.participants = fewest->clusters;
    verdict.note += fmt::format("; the fewest that can be judged with other recordings are {} participants",
                                kFewestJudged);
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
  if (const auto accepted = read_beside<AcceptedBaseline>(baseline)) {
    report.baseline_time = accepted->time;
    report.baseline_reason = accepted->reason;
  }
  return report;
}

}  // namespace trilat
