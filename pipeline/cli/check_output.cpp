// SPDX-License-Identifier: MIT
#include "pipeline/cli/check_output.h"

#include <algorithm>
#include <fstream>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/json.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

// The document, or an empty one where it is none of this format.
Json document(const fs::path& file, const std::string& format) {
  if (!fs::is_regular_file(file)) return Json::object();
  try {
    Json json = read_json(file);
    return json.is_object() && json.contains("format") && json["format"] == format ? json : Json::object();
  } catch (const InputError&) {
    return Json::object();
  }
}

Json run_json(const fs::path& folder) { return document(folder / "run.json", "trilat.run"); }

std::optional<OutputMark> mark_in(const fs::path& folder) {
  const Json json = run_json(folder);
  if (!json.contains("verb") || !json["verb"].is_string()) return std::nullopt;
  OutputMark mark{json["verb"].get<std::string>(), {}, {}};
  for (const Json& name : json.value("names", Json::array()))
    if (name.is_string()) mark.names.push_back(name);
  if (json.contains("campaign") && json["campaign"].is_string()) mark.campaign = json["campaign"];
  return mark;
}

std::string text_of(const OutputMark& mark) {
  std::string text = fmt::format("what `trilat {}` wrote", mark.verb);
  if (!mark.names.empty()) text += fmt::format(" of \"{}\"", fmt::join(mark.names, "\", \""));
  return mark.campaign.empty() ? text : text + " on campaign \"" + mark.campaign + '"';
}

bool is_same_thing(const OutputMark& there, const OutputMark& now) {
  const auto is_common = [&](const std::string& name) {
    return std::ranges::find(there.names, name) != there.names.end();
  };
  return there.verb == now.verb && there.campaign == now.campaign &&
         (now.names.empty() || std::ranges::any_of(now.names, is_common));
}

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::equivalent(a, b, error) && !error;
}

// Also through links, symbolic and hard.
bool is_inside(const fs::path& folder, const fs::path& path) {
  std::error_code error;
  for (const fs::directory_entry& entry :
       fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied, error))
    if (is_same_file(entry.path(), path)) return true;
  return false;
}

// Refuses an output that is an input; a former output of the verb may lie among its inputs.
void refuse_inputs(const OutputRequest& output, bool is_own) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(output.path.string(), why + "; an output is never an input, whatever is forced");
  };
  for (const fs::path& input : output.inputs) {
    if (input.empty()) continue;
    if (is_same_file(output.path, input)) refuse("is " + input.string() + ", which is read");
    if (is_same_file(output.path.string() + output.aside, input))
      refuse("would be written to " + input.string() + " first, which is read");
    if (fs::is_directory(input) && fs::exists(output.path) && !is_own && is_inside(input, output.path))
      refuse("belongs to " + input.string() + ", which is read");
    if (fs::is_directory(output.path) && lies_in(fs::canonical(output.path), fs::weakly_canonical(input)))
      refuse("holds " + input.string() + ", which is read");
  }
}

// Nothing, a store that was copied here, or a mark that another shard writes at this moment.
bool holds_nothing_else(const fs::path& folder) {
  return std::ranges::all_of(fs::directory_iterator(folder), [](const fs::directory_entry& entry) {
    const std::string name = entry.path().filename().string();
    return name == "items" || (name.starts_with("run.json.") && name.ends_with(".partial"));
  });
}

// A mark, as a run leaves it that was refused before it computed anything.
bool holds_a_mark_alone(const fs::path& folder) {
  return std::ranges::all_of(fs::directory_iterator(folder), [](const fs::directory_entry& entry) {
    return entry.path().filename() == "run.json";
  });
}

[[noreturn]] void refuse(const fs::path& output, const std::string& what) {
  throw InputError(output.string(), what + ". Choose another name, or replace it with --force");
}

}  // namespace

void check_output_folder(const OutputRequest& output, const OutputMark& mark) {
  const bool is_there = fs::exists(fs::symlink_status(output.path)),
             is_folder = fs::is_directory(output.path);
  const bool is_empty = is_folder && (holds_nothing_else(output.path) || holds_a_mark_alone(output.path));
  const std::optional<OutputMark> there = is_folder ? mark_in(output.path) : std::nullopt;
  const bool is_own = is_empty || (there && is_same_thing(*there, mark));
  refuse_inputs(output, is_own);
  if (!is_there || is_own) return;
  if (fs::exists(output.path) && !is_folder)
    throw InputError(output.path.string(), "is a file; a folder is needed");
  if (output.force) return;
  if (there) refuse(output.path, "holds " + text_of(*there));
  refuse(output.path, "exists and was not written by `trilat " + mark.verb + "`");
}

void mark_output(const fs::path& folder, const OutputMark& mark) {
  make_folder(folder);
  Json json = run_json(folder);
  const Json before = json;
  json.update(Json{{"format", "trilat.run"}, {"version", 1}});
  json.update(json_of(mark));
  if (json != before) write_file(folder / "run.json", json.dump(1) + "\n");
}

void check_output_file(const OutputRequest& output, bool is_own) {
  refuse_inputs(output, is_own);
  check_output_file(output.path);
  if (!fs::exists(fs::symlink_status(output.path)) || is_own) return;
  if (fs::exists(output.path) && fs::is_other(output.path))
    throw InputError(output.path.string(), "is a device, a pipe or a socket, and no file");
  if (!output.force) refuse(output.path, "exists");
}

bool begins_with(const fs::path& file, const std::string& part) {
  std::string text(1024, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text.empty() || text.find(part) != std::string::npos;
}

}  // namespace trilat
