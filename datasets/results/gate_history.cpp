// SPDX-License-Identifier: MIT
#include "datasets/results/gate_history.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

constexpr const char* kHistoryFormat = "trilat.history";
constexpr int kVersion = 2;
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

HistoryEntry read_entry(const std::string& line, const std::string& place) {
  const Json json = parse_json(line, place);
  JsonObject object(json, place, "");
  check_format(object, kHistoryFormat, kVersion);
  HistoryEntry entry;
  read_fields(object, entry);
  return entry;
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
  Json json{{"format", kHistoryFormat}, {"version", kVersion}};
  json.update(json_of(entry));
  write_file(path, text + json_text(json, -1) + "\n");
}

}  // namespace trilat
