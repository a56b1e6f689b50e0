// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "pipeline/gate/gate_report.h"

namespace trilat {
namespace {

constexpr std::size_t kMostPlaces = 4;    // of one method or study that are told in full
constexpr std::size_t kMostMethods = 12;  // entries of a list

std::string value_text(const GateFinding& f, double value) {
  if (std::isnan(value)) return "nothing";
  if (f.unit == "m") return fmt::format("{:.2f} cm", 100.0 * value);
  return fmt::format("{:.6g}", value);
}

std::string chance_text(double chance) {
  if (std::isnan(chance) || chance == 0.0) return "";
  return chance < 1e-6 ? ", chance below 1 in a million" : fmt::format(", chance {:.1g}", chance);
}

std::string size_text(const GateFinding& f) {
  std::string text;
  const Change& c = f.change;
  if (!std::isnan(c.percent))
    text = fmt::format("{:+.1f} {}", c.percent, f.kind == FindingKind::status ? "points" : "%");
  if (!std::isnan(c.low)) text += fmt::format(" ({:+.1f} to {:+.1f})", c.low, c.high);
  const std::string values = fmt::format("{} -> {}", value_text(f, f.before), value_text(f, f.now));
  if (!std::isnan(f.before) || !std::isnan(f.now)) text += (text.empty() ? "" : ", ") + values;
  return text + chance_text(c.chance);
}

std::string place_text(const GateFinding& f) {
  std::string text = f.condition;
  if (!f.group.empty()) text += (text.empty() ? "" : ", ") + f.group;
  if (!f.alignment.empty()) text += fmt::format(" (alignment {})", f.alignment);
  return text;
}

std::string line_of(const GateFinding& f) {
  std::string text = place_text(f);
  if (f.method.empty() || f.kind == FindingKind::number) text = f.what;
  text += (text.empty() ? "" : ": ") + size_text(f);
  if (!f.note.empty()) text += (text.empty() || text.ends_with(": ") ? "" : "; ") + f.note;
  return text;
}

std::string heading_of(const GateFinding& f) {
  std::string text = f.study.empty() ? "" : f.study + ", ";
  if (!f.method.empty()) text += f.method + ": ";
  switch (f.kind) {
    case FindingKind::accuracy:
      return text + (f.direction == Direction::worse ? "larger errors" : "smaller errors");
    case FindingKind::coverage:
      return text + (f.direction == Direction::worse ? "answers less often" : "answers more often");
    case FindingKind::status:
      if (f.direction == Direction::changed) return text + "answers end in other ways";
      return text +
             (f.direction == Direction::worse ? "more answers are clamped" : "fewer answers are clamped");
    case FindingKind::failure:
      return text + "fails";
    case FindingKind::number:
      return text + "numbers " + name_of(f.direction);
  }
  return text;
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
  for (std::size_t l = 0; l < std::min(lists.size(), kMostMethods); ++l) {
    const GateFinding& first = *lists[l].front();
    text += fmt::format("\n{}\n", heading_of(first));
    for (std::size_t i = 0; i < std::min(lists[l].size(), kMostPlaces); ++i)
      text += fmt::format("  {}\n", line_of(*lists[l][i]));
    if (lists[l].size() > kMostPlaces)
      text += fmt::format("  and {} places more\n", lists[l].size() - kMostPlaces);
    if (!first.since.empty()) text += fmt::format("  since {}\n", first.since);
    if (!first.command.empty()) text += fmt::format("  see: {}\n", first.command);
  }
  if (lists.size() > kMostMethods)
    text += fmt::format("\nand {} more; --json lists all\n", lists.size() - kMostMethods);
}

std::string studies_text(const GateReport& report) {
  std::map<StudyState, std::string> names;
  for (const StudyVerdict& s : report.studies) {
    std::string& list = names[s.state];
    list += (list.empty() ? "" : ", ") + s.study;
  }
  std::string text;
  const auto add = [&](StudyState state, const char* what) {
    if (names.contains(state)) text += fmt::format("{}: {}\n", what, names[state]);
  };
  add(StudyState::identical, "identical to the byte");
  add(StudyState::same_values, "the same numbers");
  add(StudyState::compared, "numbers differ");
  add(StudyState::not_judged, "numbers differ, not judged");
  add(StudyState::only_now, "new, not in the baseline");
  add(StudyState::only_before, "only in the baseline");
  return text;
}

// Which methods the alarms are about, those with the most first; empty when a look at the headings tells.
std::string methods_text(const GateReport& report) {
  constexpr std::size_t kFewHeadings = 3, kMost = 5;
  if (together(report.findings, true).size() <= kFewHeadings) return "";
  struct Hit {
    std::string method;
    std::size_t places = 0;
    std::set<std::string> studies = {};
  };
  std::vector<Hit> hits;
  for (const GateFinding& f : report.findings) {
    if (!f.alarm || f.method.empty()) continue;
    auto hit = std::ranges::find_if(hits, [&](const Hit& h) { return h.method == f.method; });
    if (hit == hits.end()) hit = hits.insert(hits.end(), Hit{f.method});
    ++hit->places;
    hit->studies.insert(f.study);
  }
  std::ranges::stable_sort(hits, [](const Hit& a, const Hit& b) { return a.places > b.places; });
  std::string text;
  for (std::size_t i = 0; i < std::min(hits.size(), kMost); ++i)
    text += fmt::format("{}{} ({} places in {} studies)", text.empty() ? "by method: " : ", ", hits[i].method,
                        hits[i].places, hits[i].studies.size());
  if (hits.size() > kMost) text += fmt::format(" and {} more", hits.size() - kMost);
  return text.empty() ? text : text + "\n";
}

std::string headline_of(const GateReport& report) {
  const std::string not_judged = not_judged_text(report);
  switch (report.verdict()) {
    case Verdict::quiet:
      return "QUIET: nothing is worse than the baseline";
    case Verdict::not_judged:
      return fmt::format("NOT JUDGED: {}, of which nobody can say whether it is worse than the baseline",
                         not_judged);
    case Verdict::regression:
      break;
  }
  return fmt::format("REGRESSION: {} thing(s) are worse than the baseline{}",
                     together(report.findings, true).size(),
                     not_judged.empty() ? "" : "; not judged: " + not_judged);
}

}  // namespace

std::string morning_text(const GateReport& report) {
  std::string text = headline_of(report);
  text += fmt::format(" ({}", report.baseline);
  if (!report.baseline_time.empty()) text += ", of " + report.baseline_time;
  text += ")\n" + methods_text(report);
  add_list(report, true, text);
  const auto better = together(report.findings, false);
  if (!better.empty()) {
    text += "\nBetter, or to be known; no alarm:\n";
    add_list(report, false, text);
  }
  text += "\n" + studies_text(report);
  for (const StudyVerdict& s : report.studies)
    if (!s.note.empty()) text += fmt::format("{}: {}\n", s.study, s.note);
  for (const std::string& note : report.notes) text += note + "\n";
  if (report.verdict() != Verdict::quiet)
    text += fmt::format("\nWhen this is meant to be: trilat gate {} --baseline {}{} --accept \"why\"\n",
                        shell_word(report.results), shell_word(report.baseline),
                        report.history.empty() ? "" : " --history " + shell_word(report.history));
  return text;
}

std::string cell_table(const GateReport& report, const std::string& method) {
  std::string text =
      fmt::format("{:<20} {:<22} {:<10} {:<8} {:>9} {:>9} {:>8} {:>18} {:>15}\n", "study", "condition",
                  "group", "aligned", "before cm", "now cm", "change %", "95 % interval", "answered");
  bool any = false;
  for (const ComparedCell& c : report.cells) {
    if (c.method != method) continue;
    any = true;
    const auto number = [](const char* how, double x) {
      return std::isnan(x) ? "-" : fmt::format(fmt::runtime(how), x);
    };
    const std::string interval =
        std::isnan(c.error.low) ? "-" : fmt::format("{:+.2f} to {:+.2f}", c.error.low, c.error.high);
    text += fmt::format("{:<20} {:<22} {:<10} {:<8} {:>9} {:>9} {:>8} {:>18} {:>15}\n", c.study, c.condition,
                        c.group, c.alignment, number("{:.3f}", 100.0 * c.before_m),
                        number("{:.3f}", 100.0 * c.now_m), number("{:+.2f}", c.error.percent), interval,
                        fmt::format("{} -> {}", c.answered_before, c.answered_now));
  }
  return any ? text : fmt::format("no cell of the method \"{}\" differs from the baseline\n", method);
}

}  // namespace trilat
