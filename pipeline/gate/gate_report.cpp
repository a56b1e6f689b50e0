// SPDX-License-Identifier: MIT
#include "pipeline/gate/gate_report.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace trilat {

namespace {

Json json_of(const GateFinding& f) {
  return {{"kind", name_of(f.kind)},
          {"direction", name_of(f.direction)},
          {"alarm", f.alarm},
          {"study", f.study},
          {"method", f.method},
          {"condition", f.condition},
          {"group", f.group},
          {"alignment", f.alignment},
          {"what", f.what},
          {"unit", f.unit},
          {"before", f.before},
          {"now", f.now},
          {"change_percent", f.percent},
          {"change_low_percent", f.percent_low},
          {"change_high_percent", f.percent_high},
          {"chance", f.chance},
          {"n", f.n},
          {"clusters", f.clusters},
          {"note", f.note},
          {"since", f.since},
          {"command", f.command}};
}

Json json_of(const ComparedCell& c) {
  return {{"study", c.study},
          {"method", c.method},
          {"condition", c.condition},
          {"group", c.group},
          {"alignment", c.alignment},
          {"before_m", c.before_m},
          {"now_m", c.now_m},
          {"change_percent", c.percent},
          {"change_low_percent", c.percent_low},
          {"change_high_percent", c.percent_high},
          {"n", c.both},
          {"clusters", c.clusters},
          {"asked", c.asked},
          {"answered_before", c.answered_before},
          {"answered_now", c.answered_now},
          {"lost", c.lost},
          {"gained", c.gained}};
}

}  // namespace

const char* name_of(StudyState state) {
  constexpr std::array<const char*, 6> kNames{"identical",  "same_values", "compared",
                                              "not_judged", "only_now",    "only_before"};
  return kNames.at(static_cast<std::size_t>(state));
}

std::uint64_t GateReport::alarms() const {
  return static_cast<std::uint64_t>(
      std::count_if(findings.begin(), findings.end(), [](const GateFinding& f) { return f.alarm; }));
}

const char* name_of(Verdict verdict) {
  constexpr std::array<const char*, 3> kNames{"quiet", "regression", "not_judged"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

Verdict GateReport::verdict() const {
  if (alarms() > 0) return Verdict::regression;
  return not_judged_text(*this).empty() ? Verdict::quiet : Verdict::not_judged;
}

std::string not_judged_text(const GateReport& report) {
  std::string text;
  for (const StudyVerdict& s : report.studies)
    if (s.state == StudyState::not_judged)
      text += fmt::format("{}{} participant{} in {}", text.empty() ? "" : ", ", s.participants,
                          s.participants == 1 ? "" : "s", s.study);
  return text;
}

Json gate_json(const GateReport& report) {
  Json json{{"format", "trilat.gate"},
            {"version", 1},
            {"time", report.time},
            {"verdict", name_of(report.verdict())},
            {"alarms", report.alarms()},
            {"results", report.results},
            {"baseline", report.baseline},
            {"baseline_accepted", report.baseline_time},
            {"baseline_reason", report.baseline_reason},
            {"smallest_effect_percent", report.smallest_percent},
            {"looked_at", report.looked_at},
            {"studies", Json::array()},
            {"findings", Json::array()},
            {"cells", Json::array()},
            {"notes", report.notes}};
  for (const StudyVerdict& s : report.studies)
    json["studies"].push_back(
        {{"study", s.study}, {"kind", s.kind}, {"state", name_of(s.state)}, {"note", s.note}});
  for (const GateFinding& f : report.findings) json["findings"].push_back(json_of(f));
  for (const ComparedCell& c : report.cells) json["cells"].push_back(json_of(c));
  return json;
}

std::string shell_word(const std::string& text) {
  const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

const char* name_of(FindingKind kind) {
  constexpr std::array<const char*, 5> kNames{"accuracy", "coverage", "status", "failure", "number"};
  return kNames.at(static_cast<std::size_t>(kind));
}

const char* name_of(Direction direction) {
  constexpr std::array<const char*, 3> kNames{"worse", "better", "changed"};
  return kNames.at(static_cast<std::size_t>(direction));
}

}  // namespace trilat
