// SPDX-License-Identifier: MIT
#include "pipeline/cli/check_output.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/calibration/calibration.h"
#include "datasets/markers/joint_files.h"
#include "datasets/skeleton/skeleton.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

std::string beginning_of(const fs::path& file) {
  std::string text(1024, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

bool begins_with(const PlannedOutput& output, const char* text) {
  return beginning_of(output.path).starts_with(text);
}

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

// A stopped run has left items and nothing else.
bool is_begun(const PlannedOutput& output) {
  std::error_code no_folder;
  const fs::directory_iterator entries(output.path, no_folder);
  return fs::is_directory(output.path / "items") &&
         std::all_of(entries, fs::directory_iterator(),
                     [](const fs::directory_entry& entry) { return entry.path().filename() == "items"; });
}

// Finished or not; a workflow engine may have removed the one file that it knows of.
bool is_results(const PlannedOutput& output) {
  return is_begun(output) || !document(output.path / "manifest.json", "trilat.manifest").empty() ||
         !document(output.path / "run.json", "trilat.run").empty();
}

// A simulation writes its documents, recordings with their truth, and items until it is finished.
bool is_of_simulation(const fs::directory_entry& entry) {
  const std::string name = entry.path().filename().string();
  return name == "campaign.json" || name == "calibration.json" || name == "simulator.json" ||
         name == "items" || fs::exists(entry.path() / "truth.json");
}

// A campaign.json that was written by hand lies beside no simulator.json, or is of real recordings.
bool is_simulated(const PlannedOutput& output) {
  std::error_code no_folder;
  const fs::directory_iterator entries(output.path, no_folder);
  if (!std::all_of(entries, fs::directory_iterator(), is_of_simulation)) return false;
  const fs::path campaign = output.path / "campaign.json";
  if (is_begun(output)) return true;
  return !document(output.path / "simulator.json", "trilat.simulator").empty() &&
         (!fs::exists(campaign) || document(campaign, "trilat.campaign").value("simulated", Json()) == true);
}

// Of this session, or of a recording that never began.
bool is_truth(const PlannedOutput& output) {
  const Json poses = document(output.path / "calibration.json", "trilat.calibration");
  if (poses.value("method", Json()) != kSimulatedTruth) return false;
  if (!fs::exists(output.path / "campaign.json")) return true;
  const Json takes = document(output.path / "campaign.json", "trilat.campaign").value("takes", Json::array());
  return takes.size() == 1 && takes[0].contains("session") && takes[0]["session"].is_string() &&
         fs::weakly_canonical(fs::absolute(output.path / takes[0]["session"].get<std::string>())) ==
             fs::weakly_canonical(fs::absolute(output.of));
}

struct KindRow {
  OutputKind kind;
  bool folder;
  bool (*is_ours)(const PlannedOutput&);
  const char* refusal;
};

bool nobodys(const PlannedOutput&) { return false; }

const KindRow kKinds[] = {
    {OutputKind::joint_table, false, [](const PlannedOutput& o) { return begins_with(o, kJointCsvHead); },
     "exists and is no table of joints"},
    {OutputKind::trc, false,
     [](const PlannedOutput& o) {
       const std::string text = beginning_of(o.path);
       return text.starts_with("PathFileType\t") &&
              text.find("Frame#\tTime\t" + std::string(name_of(Joint{}))) != std::string::npos;
     },
     "exists and is no TRC file of this program"},
    {OutputKind::calibration, false,
     [](const PlannedOutput& o) { return document(o.path, "trilat.calibration").contains("program"); },
     "exists and is no calibration of `trilat calibrate`"},
    {OutputKind::junit, false,
     [](const PlannedOutput& o) {
       return beginning_of(o.path).find("<testsuite name=\"trilat gate\"") != std::string::npos;
     },
     "exists and is no verdict of `trilat gate`"},
    {OutputKind::history, false,
     [](const PlannedOutput& o) {
       const std::string text = beginning_of(o.path);
       return text.empty() || text.find("\"format\":\"trilat.history\"") != std::string::npos;
     },
     "exists and is no history of `trilat gate`"},
    {OutputKind::session, false, nobodys, "exists; a recording is never written over another"},
    {OutputKind::truth, true, is_truth, "exists and is not the truth of an earlier try at this recording"},
    {OutputKind::campaign, true, is_simulated,
     "exists and is not an earlier simulation, or holds more than that"},
    {OutputKind::results, true, is_results, "exists and is not a results folder"},
    {OutputKind::report, true,
     [](const PlannedOutput& o) {
       return beginning_of(o.path / "report.html").find("<meta name=\"generator\" content=\"trilat ") !=
                  std::string::npos ||
              beginning_of(o.path / "citation.bib").find("@software{trilat,") != std::string::npos;
     },
     "exists and is not an earlier report"},
    {OutputKind::reproduction, true, [](const PlannedOutput& o) { return fs::exists(o.path / "campaign"); },
     "exists and is not an earlier reproduction"}};

const KindRow& row_of(OutputKind kind) {
  return *std::find_if(std::begin(kKinds), std::end(kKinds),
                       [&](const KindRow& r) { return r.kind == kind; });
}

bool is_same(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::equivalent(a, b, error) && !error;
}

// Also through links, symbolic and hard.
bool is_inside(const fs::path& folder, const fs::path& path) {
  std::error_code error;
  for (const fs::directory_entry& entry :
       fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied, error))
    if (is_same(entry.path(), path)) return true;
  return false;
}

void refuse_inputs(const PlannedOutput& output, bool ours) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(output.path.string(), why + "; an output is never an input, whatever is forced");
  };
  for (const fs::path& input : output.inputs) {
    if (input.empty()) continue;
    if (is_same(output.path, input)) refuse("is " + input.string() + ", which is read");
    if (is_same(output.path.string() + output.aside, input))
      refuse("would be written to " + input.string() + " first, which is read");
    if (fs::is_directory(input) && fs::exists(output.path) && !ours && is_inside(input, output.path))
      refuse("belongs to " + input.string() + ", which is read");
    if (fs::is_directory(output.path) && lies_in(fs::canonical(output.path), fs::weakly_canonical(input)))
      refuse("holds " + input.string() + ", which is read");
  }
}

bool is_empty_folder(const fs::path& path) { return fs::is_directory(path) && fs::is_empty(path); }

}  // namespace

void check_output(const PlannedOutput& output) {
  const KindRow& row = row_of(output.kind);
  const bool there = fs::exists(fs::symlink_status(output.path));
  const bool empty = row.folder && is_empty_folder(output.path);
  const bool ours = there && (empty || row.is_ours(output));
  refuse_inputs(output, ours);
  if (!row.folder) check_output_file(output.path);
  if (!there || ours) return;
  if (row.folder && fs::exists(output.path) && !fs::is_directory(output.path))
    throw InputError(output.path.string(), "is a file; a folder is needed");
  if (fs::exists(output.path) && fs::is_other(output.path))
    throw InputError(output.path.string(), "is a device, a pipe or a socket, and no file");
  if (!output.force)
    throw InputError(output.path.string(),
                     std::string(row.refusal) + ". Choose another name, or replace it with --force");
}

namespace {

[[noreturn]] void refuse_other(const fs::path& output, const std::string& what) {
  throw InputError(output.string(), "holds " + what + "; --force replaces it, or take another name");
}

// The inputs of a manifest, by take and role.
std::map<std::pair<std::string, std::string>, std::string> hashes_of(const Json& manifest) {
  std::map<std::pair<std::string, std::string>, std::string> hashes;
  for (const Json& input : manifest.value("inputs", Json::array()))
    if (input.contains("sha256") && input["sha256"].is_string())
      hashes[{input.value("take", ""), input.value("role", "")}] = input["sha256"];
  return hashes;
}

// Small files first, so that the large ones are rarely read.
bool has_equal_input(const Campaign& campaign, const Json& manifest) {
  const auto hashes = hashes_of(manifest);
  const auto is_equal = [&](const Take& take, const char* role, const fs::path& file) {
    const auto known = hashes.find({take.id, role});
    return known != hashes.end() && fs::is_regular_file(file) && hash_of_file(file) == known->second;
  };
  for (const auto& [role, member] : {std::pair{"mapping", &Take::mapping},
                                     {"calibration", &Take::calibration},
                                     {"mocap", &Take::mocap},
                                     {"session", &Take::session}})
    for (const Take& take : campaign.takes)
      if (is_equal(take, role, take.*member)) return true;
  return false;
}

}  // namespace

void refuse_other_results(const fs::path& output, const std::string& study, const Campaign* campaign,
                          bool force) {
  const Json manifest = document(output / "manifest.json", "trilat.manifest");
  if (force || manifest.empty()) return;
  const std::string name = manifest.value("study", Json::object()).value("name", "");
  if (!study.empty() && name != study) refuse_other(output, "study \"" + name + "\"");
  if (!campaign) return;
  const std::string other = manifest.value("campaign", "");
  if (other != campaign->name) refuse_other(output, "study \"" + name + "\" of campaign \"" + other + '"');
  if (!has_equal_input(*campaign, manifest))
    refuse_other(output, "study \"" + name + "\" of another campaign that is called \"" + other + "\", too");
}

void refuse_other_report(const fs::path& output, const std::vector<fs::path>& results, bool force) {
  if (force || !fs::is_directory(output / "studies")) return;
  std::set<std::string> there, now;
  for (const fs::directory_entry& entry : fs::directory_iterator(output / "studies"))
    if (const Json study = read_json(entry.path()); study.is_object()) there.insert(study.value("name", ""));
  for (const fs::path& folder : results)
    now.insert(document(folder / "manifest.json", "trilat.manifest")
                   .value("study", Json::object())
                   .value("name", ""));
  if (there.empty() ||
      std::ranges::any_of(there, [&](const std::string& name) { return now.contains(name); }))
    return;
  refuse_other(output, fmt::format("a report of {}", fmt::join(there, ", ")));
}

void refuse_other_calibration(const fs::path& output, const std::vector<fs::path>& inputs, bool force) {
  const Json sources = document(output, "trilat.calibration").value("sources", Json::array());
  if (force || sources.empty()) return;
  std::set<std::string> there;
  for (const Json& source : sources) there.insert(source.value("sha256", ""));
  for (const fs::path& input : inputs)
    if (fs::is_regular_file(input) && there.contains(hash_of_file(input))) return;
  refuse_other(output, "a calibration of other recordings (" + sources.front().value("file", "") + ")");
}

void refuse_other_campaign(const fs::path& output, const std::string& name, bool force) {
  const Json campaign = document(output / "campaign.json", "trilat.campaign");
  if (force || campaign.empty() || campaign.value("name", "") == name) return;
  refuse_other(output, "campaign \"" + campaign.value("name", "") + '"');
}

}  // namespace trilat
