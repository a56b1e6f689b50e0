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

std::int64_t version_of(StudyKind kind) {
  if (kind == StudyKind::accuracy) return 12;
  return kind == StudyKind::calibration ? 4 : 3;
}

// Says what a folder is that holds no results.
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

void refuse_removed_kinds(const Fields& f) {
  f.removed("kind", "variations", "scripts/vary varies a simulation");
  f.removed("kind", "recording", "kind clocks takes a campaign's sessions");
}

// First keys of a study and of summary.json.
struct StudyHead {
  static constexpr bool kHasMore = true;
  StudyKind kind = StudyKind::accuracy;

  static void fields(auto& self, auto&& f) {
    if (f.has("format", true)) f.format("trilat.study");
    refuse_removed_kinds(f);
    f("kind", self.kind);
  }
};
struct AnyResults {
  static constexpr bool kHasMore = true;
  StudyKind kind = StudyKind::accuracy;

  static void fields(auto& self, auto&& f) { visit_results_head(f, self.kind); }
};

}  // namespace

StudyKind study_kind(const Json& study, const std::string& place) {
  return read_as<StudyHead>(study, {place}).kind;
}

Json read_results_json(const std::filesystem::path& folder) {
  const auto path = folder / "summary.json";
  if (!std::filesystem::exists(path)) throw InputError(folder.string(), what_it_is_instead(folder));
  return read_json(path);
}

StudyKind results_kind(const std::filesystem::path& folder) {
  return read_as<AnyResults>(read_results_json(folder), {folder / "summary.json"}).kind;
}

void visit_results_head(Fields& f, StudyKind& kind) {
  std::string format = kFormat;
  std::int64_t version = version_of(kind);
  f("format", format);
  if (format != kFormat) f.refuse("format", std::string("must be \"") + kFormat + '"');
  refuse_removed_kinds(f);
  f("version", version);
  f("kind", kind, kMayLack);
  if (version != version_of(kind))
    f.refuse("version",
             fmt::format("is that of another trilat; this one reads version {} of kind \"{}\"; the "
                         "same `trilat run` line makes the results anew in place",
                         version_of(kind), name_of(kind)));
}

void visit_results_head_of(Fields& f, StudyKind wanted) {
  StudyKind kind = wanted;
  visit_results_head(f, kind);
  if (kind != wanted)
    f.refuse("kind",
             "is \"" + name_of(kind) + "\"; results of kind \"" + name_of(wanted) + "\" are needed here");
}

}  // namespace trilat
