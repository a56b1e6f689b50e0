// SPDX-License-Identifier: MIT
#include "datasets/results/results_file.h"

#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/results/item_store.h"

namespace trilat {
namespace {

constexpr const char* kFormat = "trilat.results";
const std::vector<std::string> kKinds{"accuracy", "threshold_sweep", "calibration", "clocks"};

std::int64_t version_of(StudyKind kind) {
  if (kind == StudyKind::accuracy) return 12;
  return kind == StudyKind::calibration ? 4 : 3;
}

// Of a place where no results are.
std::string what_it_is_instead(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  if (fs::exists(folder / "campaign.json"))
    return "is a campaign; `trilat run STUDY.json --campaign " + folder.string() +
           " -o RESULTS` makes results of it";
  if (fs::exists(folder) && !fs::is_directory(folder))
    return "is a file; a results folder is meant, which `trilat run` makes";
  if (const std::string unfinished = unfinished_results(folder); !unfinished.empty()) return unfinished;
  if (!fs::exists(folder)) return "does not exist; `trilat run` makes results folders";
  return "holds no summary.json, so it is not a results folder, which `trilat run` makes";
}

void refuse_removed(JsonObject& object) {
  if (object.value("kind") == "variations")
    object.refuse("kind", "\"variations\" was removed; scripts/vary varies a simulation");
  if (object.value("kind") == "recording")
    object.refuse("kind", "\"recording\" was removed; kind clocks takes a campaign's sessions");
}

}  // namespace

StudyKind study_kind(const Json& study, const std::string& place) {
  JsonObject object(study, place, "");
  if (object.has("format")) object.format("trilat.study");
  refuse_removed(object);
  return static_cast<StudyKind>(object.choice("kind", kKinds));
}

std::string name_of(StudyKind kind) { return kKinds.at(static_cast<std::size_t>(kind)); }

Json read_results_json(const std::filesystem::path& folder) {
  const auto path = folder / "summary.json";
  if (!std::filesystem::exists(path)) throw InputError(folder.string(), what_it_is_instead(folder));
  return read_json(path);
}

StudyKind results_kind(const std::filesystem::path& folder) {
  const Json json = read_results_json(folder);
  JsonObject object(json, (folder / "summary.json").string(), "");
  return results_kind(object);
}

StudyKind results_kind(JsonObject& summary) {
  if (summary.text("format") != kFormat) summary.refuse("format", std::string("must be \"") + kFormat + '"');
  if (summary.has("kind")) refuse_removed(summary);
  const auto kind = static_cast<StudyKind>(summary.choice("kind", kKinds, 0));
  if (summary.integer("version") != version_of(kind))
    summary.refuse(
        "version",
        fmt::format("is that of another trilat; this one reads version {} of kind \"{}\"; the same "
                    "`trilat run` line makes the results anew in place",
                    version_of(kind), name_of(kind)));
  return kind;
}

Json results_head(StudyKind kind) {
  return {{"format", kFormat}, {"version", version_of(kind)}, {"kind", name_of(kind)}};
}

void check_results_head(JsonObject& object, StudyKind wanted) {
  const StudyKind kind = results_kind(object);
  if (kind != wanted)
    object.refuse(
        "kind", "is \"" + name_of(kind) + "\"; results of kind \"" + name_of(wanted) + "\" are needed here");
}

void check_same_run(JsonObject& manifest, StudyKind kind, const std::string& study,
                    const std::string& campaign) {
  const auto same = [](JsonObject& object, const char* key, const std::string& wanted) {
    if (const std::string found = object.text(key); found != wanted)
      object.refuse(key, fmt::format("is \"{}\", and that of summary.json beside it \"{}\": the folder holds "
                                     "parts of two runs; run the study again",
                                     found, wanted));
  };
  JsonObject of_study = manifest.object("study");
  same(of_study, "kind", name_of(kind));
  same(of_study, "name", study);
  if (manifest.has("campaign") && !campaign.empty()) same(manifest, "campaign", campaign);
}

void check_format(JsonObject& object, const std::string& format, int version) {
  if (object.text("format") != format) object.refuse("format", "must be \"" + format + '"');
  if (object.integer("version") != version)
    object.refuse("version", fmt::format("is another version; this program reads version {}", version));
}

}  // namespace trilat
