// SPDX-License-Identifier: MIT
#include "pipeline/gate/found_results.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"

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

// A folder whose manifest and summary are of different runs.
void refuse_mixed(const FoundResults& found, const Json& study) {
  const auto same = [&](const char* key, const Json& of_manifest, const std::string& wanted) {
    if (of_manifest.is_string() && of_manifest.get<std::string>() != wanted)
      throw InputError((found.folder / "manifest.json").string() + " " + key,
                       fmt::format("is \"{}\", and that of summary.json beside it \"{}\": the folder holds "
                                   "parts of two runs; run the study again",
                                   of_manifest.get<std::string>(), wanted));
  };
  const bool budget = found.kind == StudyKind::error_budget;
  same("/study/kind", study.value("kind", Json()), name_of(budget ? StudyKind::accuracy : found.kind));
  const std::string name = text_of(found.summary, "study"), campaign = text_of(found.summary, "campaign");
  if (!name.empty()) same("/study/name", study.value("name", Json()), name);
  if (!campaign.empty()) same("/campaign", found.manifest.value("campaign", Json()), campaign);
}

FoundResults read_found(const fs::path& folder, const std::string& name) {
  FoundResults found;
  found.folder = folder;
  found.kind = results_kind(folder);
  found.summary = read_results_json(folder);
  found.manifest = read_json(folder / "manifest.json");
  const fs::path manifest = folder / "manifest.json";
  if (!found.manifest.is_object() || found.manifest.value("format", Json()) != "trilat.manifest" ||
      found.manifest.value("version", Json()) != 1)
    throw InputError(manifest.string(),
                     "is no manifest of this program's version (trilat.manifest, version 1)");
  const Json study = found.manifest.value("study", Json::object());
  if (!study.is_object() || !study.contains("name") || !study["name"].is_string())
    throw InputError(manifest.string() + " /study/name", "is missing");
  found.study = study["name"].get<std::string>();
  found.name = name.empty() ? found.study : name;
  refuse_mixed(found, study);
  if (found.summary.value("interrupted", Json(false)) == true)
    throw InputError((folder / "summary.json").string() + " /interrupted",
                     "is true: the run was not finished. Run it again");
  if (found.kind == StudyKind::accuracy) {
    if (!fs::exists(folder / "samples.h5"))
      throw InputError((folder / "samples.h5").string(), "is missing: results are compared sample by sample");
    if (found.summary.value("cells", Json::array()).empty())
      throw InputError((folder / "summary.json").string() + " /cells", "is empty: nothing was evaluated");
  }
  return found;
}

void refuse_unfinished(const fs::path& partial) {
  throw InputError(partial.string(), "is what an unfinished run left. Run it again, or remove it");
}

}  // namespace

ResultsSet find_results(const fs::path& given) {
  const fs::path folder = given.has_filename() ? given : given.parent_path();
  if (!fs::is_directory(folder))
    throw InputError(folder.string(), "is no folder; results, or a folder that holds several, are needed");
  if (folder.extension() == ".partial") refuse_unfinished(folder);
  ResultsSet set;
  if (is_results(folder)) {
    set.single = true;
    set.results.push_back(read_found(folder, ""));
    return set;
  }
  std::vector<fs::path> inside;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory()) inside.push_back(entry.path());
  std::sort(inside.begin(), inside.end());
  for (const fs::path& path : inside) {
    if (path.extension() == ".partial") refuse_unfinished(path);
    if (is_results(path)) set.results.push_back(read_found(path, path.filename().string()));
  }
  if (set.results.empty())
    throw InputError(folder.string(), "holds no results: neither a summary.json nor folders with one");
  return set;
}

PairedSet pair_results(ResultsSet now, ResultsSet before) {
  const bool by_study = now.single || before.single;
  const auto matches = [&](const FoundResults& a, const FoundResults& b) {
    return by_study ? a.study == b.study : a.name == b.name;
  };
  PairedSet set;
  if (now.single &&
      before.single) {  // whatever their names: a difference is then told as one of configuration
    set.pairs.push_back({std::move(now.results[0]), std::move(before.results[0])});
    return set;
  }
  for (FoundResults& here : now.results) {
    const auto there = std::find_if(before.results.begin(), before.results.end(),
                                    [&](const FoundResults& b) { return matches(here, b); });
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

}  // namespace trilat
