// SPDX-License-Identifier: MIT
#include "pipeline/gate/gate_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/text_output.h"
#include "datasets/base/units.h"
#include "datasets/base/words.h"
#include "datasets/results/summary.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxPlaces = 4;    // of one method or study that are printed in full
constexpr std::size_t kMaxMethods = 12;  // entries of a list

std::string value_text(const GateFinding& f, double value) {
  if (std::isnan(value)) return "nothing";
  if (f.unit == "m") return fmt::format("{:.2f} cm", kCentimetresPerMetre * value);
  if (f.unit == "rad") return fmt::format("{:.2f} degrees", kDegreesPerRad * value);
  return fmt::format("{:.6g}{}{}", value, f.unit.empty() || f.unit == "1" ? "" : " ",
                     f.unit == "1" ? "" : f.unit);
}

// "+7.7 % (+3.1 to +12.3), 4.10 cm -> 4.42 cm, p = 0.0004"
std::string size_text(const GateFinding& f) {
  std::string text;
  if (!std::isnan(f.percent)) text = fmt::format("{:+.1f} %", f.percent);
  if (!std::isnan(f.low)) text += fmt::format(" ({:+.1f} to {:+.1f})", f.low, f.high);
  if (!std::isnan(f.before) || !std::isnan(f.now))
    text +=
        fmt::format("{}{} -> {}", text.empty() ? "" : ", ", value_text(f, f.before), value_text(f, f.now));
  if (!std::isnan(f.p_value))
    text += f.p_value < 1e-6 ? ", p below 1e-6" : fmt::format(", p = {:.1g}", f.p_value);
  return text;
}

std::string what_text(const GateFinding& f) {
  switch (f.kind) {
    case FindingKind::accuracy:
      return f.direction == Direction::worse    ? "larger errors"
             : f.direction == Direction::better ? "smaller errors"
                                                : "errors of one night alone";
    case FindingKind::coverage:
      return f.direction == Direction::worse ? "answers less often" : "answers more often";
    case FindingKind::failure:
      return "fails";
    case FindingKind::number:
      return "numbers changed";
  }
  return "";
}

// "walking, head: +2.0 %, …"
std::string line_of(const GateFinding& f) {
  std::string text = f.method.empty() ? f.what : f.condition + (f.group.empty() ? "" : ", " + f.group);
  const std::string size = size_text(f);
  text += (text.empty() || size.empty() ? "" : ": ") + size;
  if (!f.note.empty()) text += (text.empty() ? "" : "; ") + f.note;
  return text;
}

std::string heading_of(const GateFinding& f) {
  return fmt::format("{}{}{}: {}", f.study, f.method.empty() ? "" : ", ", f.method, what_text(f));
}

// Findings of one study, method and kind belong together: several places, one cause.
std::vector<std::vector<const GateFinding*>> together(const std::vector<GateFinding>& findings, bool alarms) {
  std::vector<std::vector<const GateFinding*>> lists;
  std::map<std::string, std::size_t> known;
  for (const GateFinding& f : findings) {
    if (f.alarm != alarms) continue;
    const auto [place, is_new] = known.try_emplace(heading_of(f), lists.size());
    if (is_new) lists.emplace_back();
    lists[place->second].push_back(&f);
  }
  return lists;
}

void add_list(const GateReport& report, bool alarms, std::string& text) {
  const auto lists = together(report.findings, alarms);
  for (std::size_t l = 0; l < std::min(lists.size(), kMaxMethods); ++l) {
    const GateFinding& first = *lists[l].front();
    text += fmt::format("\n{}\n", heading_of(first));
    for (std::size_t i = 0; i < std::min(lists[l].size(), kMaxPlaces); ++i)
      text += fmt::format("  {}\n", line_of(*lists[l][i]));
    if (lists[l].size() > kMaxPlaces)
      text += fmt::format("  and {} places more: --json\n", lists[l].size() - kMaxPlaces);
    if (!first.since.empty()) text += fmt::format("  since {}\n", first.since);
  }
  if (lists.size() > kMaxMethods)
    text += fmt::format("\nand {} more; --json lists all\n", lists.size() - kMaxMethods);
}

std::string studies_text(const GateReport& report) {
  constexpr std::array<const char*, 5> kWhat{"every number the same", "numbers differ",
                                             "numbers differ, not judged", "new, not in the baseline",
                                             "only in the baseline"};
  std::string text;
  for (std::size_t state = 0; state < kWhat.size(); ++state) {
    std::vector<std::string> names;
    for (const StudyVerdict& s : report.studies)
      if (s.state == static_cast<StudyState>(state)) names.push_back(s.study);
    if (!names.empty()) text += fmt::format("{}: {}\n", kWhat[state], fmt::join(names, ", "));
  }
  return text;
}

// "table3, nonlinear, walking, elbow: larger errors, +7.7 %, …"
std::string worst_text(const GateReport& report) {
  const GateFinding& worst = report.findings.front();
  std::string text = worst.study;
  for (const std::string* part : {&worst.method, &worst.condition, &worst.group})
    if (!part->empty()) text += ", " + *part;
  text += ": " + (worst.method.empty() ? worst.what : what_text(worst));
  const std::string size = size_text(worst);
  if (!size.empty()) text += ", " + size;
  if (report.alarms() > 1) text += fmt::format("; and {} more", report.alarms() - 1);
  return text;
}

std::string headline_of(const GateReport& report) {
  const std::string not_judged = not_judged_text(report);
  switch (report.verdict()) {
    case NightVerdict::quiet:
      return "QUIET: nothing is worse than the baseline";
    case NightVerdict::not_judged:
      return fmt::format("NOT JUDGED: {}; whether it is worse than the baseline cannot be decided",
                         not_judged);
    case NightVerdict::regression:
    case NightVerdict::accepted:
      break;
  }
  return "REGRESSION: " + worst_text(report) + (not_judged.empty() ? "" : "; not judged: " + not_judged);
}

}  // namespace

GateFinding finding_of(const CellName& cell, FindingKind kind, Direction direction, bool alarm) {
  GateFinding finding;
  static_cast<CellName&>(finding) = cell;
  finding.kind = kind;
  finding.direction = direction;
  finding.alarm = alarm;
  return finding;
}

void sort_findings(std::vector<GateFinding>& findings) {
  const auto size = [](const GateFinding& f) {
    if (std::isnan(f.percent)) return f.kind == FindingKind::number ? 0.0 : HUGE_VAL;
    return std::abs(f.percent);
  };
  std::ranges::stable_sort(findings, [&](const GateFinding& a, const GateFinding& b) {
    const auto order = [&](const GateFinding& f) {
      return std::tuple(!f.alarm, f.kind == FindingKind::number, -size(f));
    };
    return order(a) < order(b);
  });
}

bool is_same(double a, double b) {
  constexpr double kSame = 1e-9;
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) == std::isnan(b);
  return std::abs(a - b) <= kSame * std::max(std::abs(a), std::abs(b));
}

double percent_of(double now, double before) {
  return before == 0.0 ? kNaN : 100.0 * (now - before) / std::abs(before);
}

std::uint64_t GateReport::alarms() const {
  return static_cast<std::uint64_t>(
      std::ranges::count_if(findings, [](const GateFinding& f) { return f.alarm; }));
}

NightVerdict GateReport::verdict() const {
  if (alarms() > 0) return NightVerdict::regression;
  return not_judged_text(*this).empty() ? NightVerdict::quiet : NightVerdict::not_judged;
}

std::string not_judged_text(const GateReport& report) {
  std::string text;
  for (const StudyVerdict& s : report.studies) {
    if (s.state != StudyState::not_judged) continue;
    text += text.empty() ? "" : ", ";
    text += s.participants == 0 ? fmt::format("other recordings in {}", s.study)
                                : counted(s.participants, "participant") + " in " + s.study;
  }
  return text;
}

std::string gate_summary(const GateReport& report) {
  std::string text = headline_of(report);
  text += fmt::format(" ({}", report.baseline);
  if (!report.baseline_time.empty()) text += ", of " + report.baseline_time;
  text += ")\n";
  for (const StudyVerdict& s : report.studies)
    if (!s.settings.empty())
      text += fmt::format("{}, other settings: {}\n", s.study, fmt::join(s.settings, "; "));
  add_list(report, true, text);
  if (!together(report.findings, false).empty()) {
    text += "\nBetter, or to be known; no alarm:\n";
    add_list(report, false, text);
  }
  text += "\n" + studies_text(report);
  for (const StudyVerdict& s : report.studies)
    if (!s.note.empty()) text += fmt::format("{}: {}\n", s.study, s.note);
  for (const std::string& note : report.notes) text += note + "\n";
  if (report.verdict() != NightVerdict::quiet)
    text += fmt::format("\nWhen this is meant to be: trilat gate {} --baseline {}{} --accept \"why\"\n",
                        shell_word(report.results), shell_word(report.baseline),
                        report.history.empty() ? "" : " --history " + shell_word(report.history));
  return text;
}

Json gate_json(const GateReport& report) {
  return {{"format", "trilat.gate"},
          {"version", 3},
          {"time", report.time},
          {"verdict", name_of(report.verdict())},
          {"alarms", report.alarms()},
          {"results", report.results},
          {"baseline", report.baseline},
          {"baseline_accepted", report.baseline_time},
          {"baseline_reason", report.baseline_reason},
          {"smallest_effect_percent", report.smallest_percent},
          {"looked_at", report.looked_at},
          {"within_limits", report.within_limits},
          {"studies", json_of(report.studies)},
          {"findings", json_of(report.findings)},
          {"notes", report.notes}};
}

namespace {

// The mean errors of all takes under the first alignment.
std::vector<Number> mean_errors_in(const ResultsSummary& summary) {
  std::vector<Number> means;
  for (const Number& number : summary.numbers.all())
    if (number.measure == "distance" && number.statistic == "mean" && number.take.empty() &&
        number.alignment == summary.alignments.front())
      means.push_back(number);
  return means;
}

}  // namespace

std::map<std::string, double> mean_errors_of(const ResultsSet& results) {
  std::map<std::string, double> errors_m;
  for (const FoundResults& found : results.results) {
    if (found.kind != StudyKind::accuracy) continue;
    const std::vector<Number> means = mean_errors_in(read_results<ResultsSummary>(found.folder));
    std::set<std::string> averaged;  // conditions of several groups
    for (const Number& mean : means)
      if (mean.group == kAverageGroup) averaged.insert(mean.condition);
    for (const Number& mean : means)
      if (mean.group == kAverageGroup || !averaged.contains(mean.condition))
        errors_m[fmt::format("{}: {}, {} (m)", found.name, mean.method, mean.condition)] = mean.value;
  }
  return errors_m;
}

std::string key_of(const GateFinding& f) {
  std::string key =
      fmt::format("{} | {} | {} | {} | {}", word_of(f.kind), f.study, f.method, f.condition, f.group);
  if (f.kind == FindingKind::number || f.kind == FindingKind::failure) key += " | " + f.what;
  std::ranges::replace(key, ';', ',');  // which separates alarms in the history
  return key;
}

std::size_t set_since(std::span<const Night> history, GateReport& report) {
  std::vector<const Night*> nights;
  for (const Night& night : history) {
    if (night.time < report.baseline_time) continue;  // judged against another baseline
    if (night.verdict == NightVerdict::accepted) nights.clear();
    nights.push_back(&night);
  }
  if (nights.empty()) return 0;
  for (GateFinding& f : report.findings) {
    if (!f.alarm) continue;
    f.since = report.time;
    const std::string key = key_of(f);
    for (auto night = nights.rbegin(); night != nights.rend(); ++night) {
      if (std::ranges::find((*night)->alarms, key) == (*night)->alarms.end()) break;
      f.since = (*night)->time;
    }
  }
  return nights.size();
}

}  // namespace trilat
