// SPDX-License-Identifier: MIT
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/gate/gate_report.h"

namespace trilat {
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
  if (!std::isnan(f.percent)) text += fmt::format(" {:+.2f} %", f.percent);
  if (!std::isnan(f.percent_low)) text += fmt::format(" ({:+.2f} to {:+.2f})", f.percent_low, f.percent_high);
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
