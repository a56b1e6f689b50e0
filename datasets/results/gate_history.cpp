// SPDX-License-Identifier: MIT
#include "datasets/results/gate_history.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {

namespace {

constexpr int kVersion = 2;
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

Json json_of(const std::map<std::string, double>& values) {
  Json json = Json::object();
  for (const auto& [name, value] : values) json[name] = value;
  return json;
}

std::map<std::string, double> read_values(JsonObject object) {
  std::map<std::string, double> values;
  for (const std::string& name : object.keys()) values[name] = number_or_nan(object, name);
  return values;
}

Json json_of(const HistoryEntry& e) {
  return {{"format", "trilat.history"},
          {"version", kVersion},
          {"time", e.time},
          {"program", e.program},
          {"accepted", e.accepted},
          {"reason", e.reason},
          {"quiet", e.quiet},
          {"alarms", e.alarms},
          {"not_judged", e.not_judged},
          {"error_m", json_of(e.error_m)},
          {"coverage", json_of(e.coverage)}};
}

HistoryEntry read_entry(const std::string& line, const std::string& place) {
  const Json json = parse_json(line, place);
  JsonObject object(json, place, "");
  check_format(object, "trilat.history", kVersion);
  HistoryEntry e;
  e.time = object.text("time");
  e.program = object.text("program");
  e.accepted = object.boolean("accepted", false);
  e.reason = object.text("reason");
  e.quiet = object.boolean("quiet", true);
  e.alarms = object.texts("alarms");
  e.not_judged = object.texts("not_judged");
  e.error_m = read_values(object.object("error_m"));
  e.coverage = read_values(object.object("coverage"));
  object.finish();
  return e;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t first = 0; first < text.size();) {
    const std::size_t end = std::min(text.find('\n', first), text.size());
    lines.push_back(text.substr(first, end - first));
    first = end + 1;
  }
  return lines;
}

}  // namespace

History read_history(const std::filesystem::path& path) {
  History history;
  if (!std::filesystem::exists(path)) return history;
  const std::string text = read_file(path, kMostBytes);
  const std::vector<std::string> lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string place = fmt::format("{}:{}", path.string(), i + 1);
    const bool torn_perhaps = i + 1 == lines.size() && !text.ends_with('\n');
    try {
      history.entries.push_back(read_entry(lines[i], place));
    } catch (const InputError&) {
      if (!torn_perhaps) throw;
      history.torn = place;
    }
  }
  return history;
}

void append_history(const std::filesystem::path& path, const HistoryEntry& entry) {
  std::string text = std::filesystem::exists(path) ? read_file(path, kMostBytes) : "";
  if (!text.empty() && !text.ends_with('\n')) {
    const std::size_t last = text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1;
    if (read_history(path).torn.empty())
      text += '\n';
    else
      text.resize(last);
  }
  write_file(path, text + json_text(json_of(entry), -1) + "\n");
}

void write_accepted(const std::filesystem::path& folder, const AcceptedBaseline& a) {
  const Json json{{"format", "trilat.accepted"},
                  {"version", 1},
                  {"reason", a.reason},
                  {"time", a.time},
                  {"program", a.program},
                  {"sha256", a.sha256},
                  {"replaces_sha256", a.replaces_sha256},
                  {"replaces_time", a.replaces_time}};
  write_file(folder / "accepted.json", json_text(json, 1) + "\n");
}

std::optional<AcceptedBaseline> read_accepted(const std::filesystem::path& folder) {
  const auto path = folder / "accepted.json";
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  check_format(object, "trilat.accepted", 1);
  AcceptedBaseline a;
  a.reason = object.text("reason");
  a.time = object.text("time");
  a.program = object.text("program");
  a.sha256 = object.text("sha256");
  a.replaces_sha256 = object.text("replaces_sha256");
  a.replaces_time = object.text("replaces_time");
  object.finish();
  return a;
}

}  // namespace trilat
