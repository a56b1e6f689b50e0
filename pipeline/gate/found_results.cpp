// SPDX-License-Identifier: MIT
#include "pipeline/gate/found_results.h"

#include <algorithm>
#include <map>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "datasets/results/item_store.h"
#include "datasets/results/numbers.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

bool is_results(const fs::path& folder) {
  return fs::exists(folder / "summary.json") || fs::exists(folder / "manifest.json");
}

std::string text_of(const Json& object, const char* key) {
  const Json value = object.value(key, Json());
  return value.is_string() ? value.get<std::string>() : "";
}

FoundResults read_found(const fs::path& folder, const std::string& name) {
  FoundResults found;
  found.folder = folder;
  found.kind = results_kind(folder);
  found.summary = read_results_json(folder);
  found.manifest = read_json(folder / "manifest.json");
  if (fs::exists(folder / kNumbersFile)) found.numbers = read_file(folder / kNumbersFile, kMaxNumbersBytes);
  const Manifest manifest = read_manifest(folder);
  found.study = manifest.study.name;
  found.name = name.empty() ? found.study : name;
  check_same_run(manifest, name_of(found.kind), text_of(found.summary, "study"),
                 text_of(found.summary, "campaign"));
  if (found.kind == StudyKind::accuracy && found.summary.value("rows", 0) == 0)
    throw InputError((folder / kNumbersFile).string(), "has no number: nothing was evaluated");
  return found;
}

// "/seed is 2 here and 1 there", one of each difference.
std::vector<std::string> differences_of(const Json& now, const Json& before) {
  constexpr std::size_t kMaxTold = 5;
  const Json steps = Json::diff(before, now);
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < std::min(steps.size(), kMaxTold); ++i) {
    const Json::json_pointer place(steps[i].at("path").get<std::string>());
    const auto value = [&](const Json& document) {
      return document.contains(place) ? shortened(document.at(place)) : "nothing";
    };
    texts.push_back(fmt::format("{} is {} here and {} there", place.to_string(), value(now), value(before)));
  }
  if (steps.size() > kMaxTold) texts.push_back(fmt::format("and {} more", steps.size() - kMaxTold));
  return texts;
}

// Gives the entries of a manifest that the user sets, without those the program makes.
Json settings_of(const Json& manifest) {
  constexpr std::size_t kHash = 12;  // characters that tell two apart
  Json settings = Json::object();
  for (const char* key : {"study", "campaign", "rig", "methods", "joints"})
    if (manifest.contains(key)) settings[key] = manifest.at(key);
  const bool simulated = manifest.value("simulated", Json(false)) == true;
  Json takes = Json::object();
  for (Json take : manifest.value("takes", Json::array())) {
    if (!take.is_object()) continue;
    const std::string id = text_of(take, "id");
    take.erase("instants");
    take.erase("id");
    if (simulated) take.erase("mocap_start_host_ns");  // its clock is drawn
    takes[id] = take;
  }
  for (const Json& input : manifest.value("inputs", Json::array())) {
    const std::string role = text_of(input, "role"), take = text_of(input, "take");
    if (role == "calibration" || role == "mapping")
      takes[take][role] = text_of(input, "sha256").substr(0, kHash);
  }
  settings["takes"] = takes;
  return settings;
}

// The hashes of what was recorded, by take; a take of which a file could not be read has none.
std::map<std::string, std::map<std::string, std::string>> recordings_of(const Json& manifest) {
  std::map<std::string, std::map<std::string, std::string>> recordings;
  for (const Json& take : manifest.value("takes", Json::array())) recordings[text_of(take, "id")];
  for (const Json& input : manifest.value("inputs", Json::array())) {
    const std::string role = text_of(input, "role");
    if (role == "session" || role == "mocap")
      recordings[text_of(input, "take")][role] = text_of(input, "sha256");
  }
  return recordings;
}

}  // namespace

std::string shortened(const Json& value) {
  constexpr std::size_t kMaxCount = 80;
  if (value.is_null()) return "nothing";
  if (!value.is_structured()) return json_text(value, -1);
  const std::string ascii = value.dump(-1, ' ', true);
  return ascii.size() <= kMaxCount ? ascii : ascii.substr(0, kMaxCount) + "…";
}

ResultsSet find_results(const fs::path& given) {
  const fs::path folder = given.has_filename() ? given : given.parent_path();
  if (!fs::is_directory(folder))
    throw InputError(folder.string(), "is not a folder; give results, or a folder that holds several");
  ResultsSet set;
  if (is_results(folder)) {
    set.single = true;
    set.results.push_back(read_found(folder, ""));
    return set;
  }
  std::vector<fs::path> inside;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory()) inside.push_back(entry.path());
  std::ranges::sort(inside);
  for (const fs::path& path : inside) {
    if (is_results(path)) set.results.push_back(read_found(path, path.filename().string()));
  }
  if (set.results.empty())
    throw InputError(folder.string(), "holds no results: neither a summary.json nor folders with one");
  return set;
}

MatchedStudies match_studies(ResultsSet now, ResultsSet before) {
  const bool by_study = now.single || before.single;
  const auto matches = [&](const FoundResults& a, const FoundResults& b) {
    return by_study ? a.study == b.study : a.name == b.name;
  };
  MatchedStudies set;
  if (now.single && before.single) {  // whatever their names: a difference is then named as one of settings
    set.pairs.push_back({std::move(now.results[0]), std::move(before.results[0])});
    return set;
  }
  for (FoundResults& here : now.results) {
    const auto there =
        std::ranges::find_if(before.results, [&](const FoundResults& b) { return matches(here, b); });
    if (there == before.results.end()) {
      set.only_now.push_back(here.name);
      continue;
    }
    set.pairs.push_back({std::move(here), std::move(*there)});
    before.results.erase(there);
  }
  for (const FoundResults& there : before.results) set.only_before.push_back(there.name);
  return set;
}

std::vector<std::string> settings_that_differ(const ResultsPair& pair) {
  return differences_of(settings_of(pair.now.manifest), settings_of(pair.before.manifest));
}

MatchedTakes match_takes(const ResultsPair& pair) {
  const auto now = recordings_of(pair.now.manifest), before = recordings_of(pair.before.manifest);
  MatchedTakes takes;
  for (const auto& [id, files] : now) {
    const auto found = before.find(id);
    if (found == before.end())
      takes.one_sided.push_back(id);
    else if (!files.empty() && files == found->second)
      takes.same.push_back(id);
    else
      takes.other.push_back(id);
  }
  for (const auto& [id, files] : before)
    if (!now.contains(id)) takes.one_sided.push_back(id);
  return takes;
}

namespace {

// Over names and contents of all files but accepted.json itself.
std::string content_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path() != folder / "accepted.json")
      files.push_back(fs::relative(entry.path(), folder));
  std::ranges::sort(files);
  std::string list;
  for (const fs::path& file : files)
    list += hash_of_file(folder / file) + "  " + file.generic_string() + "\n";
  return hash_of_text(list);
}

void copy_to(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy(from, to, fs::copy_options::recursive, error);
  if (error)
    throw OutputError(to.string(), "cannot be copied from " + from.string() + ": " + error.message());
}

// All files but what is known of the hashes of others. Items are kept for their samples: what one night
// answers and the other does not is not compared.
void copy_results(const fs::path& from, const fs::path& to) {
  make_folder(to);
  for (const fs::directory_entry& entry : fs::directory_iterator(from))
    if (entry.path().filename() != "hashes.json") copy_to(entry.path(), to / entry.path().filename());
}

// A folder that is filled beside the baseline and takes its place at the end.
class NewBaseline {
 public:
  explicit NewBaseline(const fs::path& baseline)
      : baseline_(baseline),
        partial_(partial_name(baseline)),
        old_(partial_.string() + ".old"),
        lock_(baseline) {
    // from a process that was killed between two renames
    if (!fs::exists(baseline_) && fs::is_directory(old_)) fs::rename(old_, baseline_);
    fs::remove_all(partial_);
    make_folder(partial_);
  }
  const fs::path& partial() const { return partial_; }
  void put_in_place() const {
    fs::remove_all(old_);
    std::error_code error;
    if (fs::exists(baseline_)) fs::rename(baseline_, old_, error);
    if (!error) fs::rename(partial_, baseline_, error);
    if (error) throw OutputError(baseline_.string(), "cannot be put in place: " + error.message());
    fs::remove_all(old_, error);
  }

 private:
  fs::path baseline_, partial_, old_;
  FolderLock lock_;
};

bool is_blank(const std::string& text) { return text.find_first_not_of(" \t\r\n") == std::string::npos; }

}  // namespace

std::vector<std::string> studies_only_in_baseline(const fs::path& results, const fs::path& baseline) {
  std::vector<std::string> names;
  if (!fs::is_directory(baseline) || fs::is_empty(baseline)) return names;
  const ResultsSet now = find_results(results), before = find_results(baseline);
  if (now.single) return names;
  for (const FoundResults& older : before.results) {
    const auto same = [&](const FoundResults& f) { return f.name == older.name; };
    if (std::ranges::none_of(now.results, same)) names.push_back(older.name);
  }
  return names;
}

AcceptedBaseline accept_results(const fs::path& results, const fs::path& given, const std::string& reason,
                                const std::string& time) {
  if (is_blank(reason))
    throw InputError("--accept", "needs a reason: why are these results right and the baseline is not?");
  const ResultsSet set = find_results(results);
  const fs::path baseline = given.has_filename() ? given : given.parent_path();
  AcceptedBaseline accepted{reason, time, kProgramVersion, "", "", ""};
  bool keeps_others = false;
  if (fs::exists(baseline) && !(fs::is_directory(baseline) && fs::is_empty(baseline))) {
    const ResultsSet before = find_results(baseline);  // never anything else's folder
    accepted.replaces_sha256 = content_of(baseline);
    if (const auto older = read_json_file<AcceptedBaseline>(baseline)) accepted.replaces_time = older->time;
    keeps_others = set.single && !before.single;
  }
  const NewBaseline folder(baseline);
  const fs::path& partial = folder.partial();
  if (keeps_others) {
    fs::remove_all(partial);
    copy_to(baseline, partial);
    std::string name = set.results[0].name;
    for (const FoundResults& other : find_results(baseline).results)
      if (other.study == set.results[0].study) name = other.name;
    fs::remove_all(partial / name);
    copy_results(set.results[0].folder, partial / name);
  } else if (set.single) {
    copy_results(set.results[0].folder, partial);
  } else {
    for (const FoundResults& found : set.results) copy_results(found.folder, partial / found.name);
  }
  accepted.sha256 = content_of(partial);
  write_json_file(partial, accepted);
  folder.put_in_place();
  return accepted;
}

}  // namespace trilat
