// SPDX-License-Identifier: MIT
#include "pipeline/gate/gate_report.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace trilat {

const char* name_of(StudyState state) {
  constexpr std::array<const char*, 6> kNames{"identical",  "same_values", "compared",
                                              "not_judged", "only_now",    "only_before"};
  return kNames.at(static_cast<std::size_t>(state));
}

std::uint64_t GateReport::alarms() const {
  return static_cast<std::uint64_t>(
      std::ranges::count_if(findings, [](const GateFinding& f) { return f.alarm; }));
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
  return {{"format", "trilat.gate"},
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
          {"studies", json_of(report.studies)},
          {"findings", json_of(report.findings)},
          {"cells", json_of(report.cells)},
          {"notes", report.notes}};
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

namespace {

// Text as XML: markup escaped, what XML 1.0 cannot hold replaced, bytes that are not UTF-8 too.
std::string xml(const std::string& text) {
  const std::string valid = Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string result;
  for (const char c : Json::parse(valid).get<std::string>()) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else if (c == '\n' || c == '\t')
      result += c == '\n' ? "&#10;" : "&#9;";
    else if (static_cast<unsigned char>(c) < 0x20)
      result += "\uFFFD";
    else
      result += c;
  }
  return result;
}

std::string name_of_case(const GateFinding& f) {
  std::string name = name_of(f.kind);
  for (const std::string* part : {&f.method, &f.condition, &f.group, &f.alignment})
    if (!part->empty()) name += " / " + *part;
  if (f.method.empty() && !f.what.empty()) name += " / " + f.what;
  return name;
}

std::string failure_text(const GateFinding& f) {
  const auto number = [](double x) { return std::isnan(x) ? "nothing" : fmt::format("{:.6g}", x); };
  std::string text = f.what;
  const Change& c = f.change;
  if (!std::isnan(c.percent)) text += fmt::format(" {:+.2f} %", c.percent);
  if (!std::isnan(c.low)) text += fmt::format(" ({:+.2f} to {:+.2f})", c.low, c.high);
  if (!std::isnan(f.before) || !std::isnan(f.now)) text += ": " + number(f.before) + " -> " + number(f.now);
  if (!f.note.empty()) text += "; " + f.note;
  if (!f.since.empty()) text += "; since " + f.since;
  return text;
}

std::string suite_of(std::size_t tests, std::uint64_t failures, std::size_t errors, std::size_t skipped,
                     const std::string& time, const std::string& cases) {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites tests=\"{0}\" failures=\"{1}\" "
      "errors=\"{2}\">\n"
      "  <testsuite name=\"trilat gate\" timestamp=\"{4}\" tests=\"{0}\" failures=\"{1}\" errors=\"{2}\" "
      "skipped=\"{3}\">\n{5}  </testsuite>\n</testsuites>\n",
      tests, failures, errors, skipped, xml(time), cases);
}

// Why a study was not compared or not judged; empty when it was.
std::string why_skipped(const StudyVerdict& s) {
  if (s.state == StudyState::only_now) return "not in the baseline";
  if (s.state == StudyState::only_before) return "only in the baseline";
  if (s.state == StudyState::not_judged)
    return fmt::format("not judged: {} participants; {}", s.participants, s.note);
  return "";
}

}  // namespace

std::string gate_junit_of_error(const std::string& time, const std::string& message) {
  return suite_of(1, 0, 1, 0, time,
                  fmt::format("    <testcase classname=\"trilat.gate\" name=\"compared with the baseline\">\n"
                              "      <error message=\"{}\"/>\n    </testcase>\n",
                              xml(message)));
}

std::string gate_junit(const GateReport& report) {
  std::string cases;
  std::size_t tests = 0, skipped = 0;
  for (const StudyVerdict& s : report.studies) {
    const std::string why = why_skipped(s);
    cases += fmt::format("    <testcase classname=\"trilat.gate.{}\" name=\"compared with the baseline\"",
                         xml(s.study));
    cases +=
        why.empty() ? "/>\n" : fmt::format(">\n      <skipped message=\"{}\"/>\n    </testcase>\n", xml(why));
    ++tests;
    skipped += !why.empty();
  }
  for (const GateFinding& f : report.findings) {
    if (!f.alarm) continue;
    cases += fmt::format(
        "    <testcase classname=\"trilat.gate.{}\" name=\"{}\">\n      <failure type=\"{}\" "
        "message=\"{}\">{}</failure>\n    </testcase>\n",
        xml(f.study), xml(name_of_case(f)), name_of(f.direction), xml(failure_text(f)), xml(f.command));
    ++tests;
  }
  return suite_of(tests, report.alarms(), 0, skipped, report.time, cases);
}

}  // namespace trilat
