// SPDX-License-Identifier: MIT
#include "pipeline/study/recordings.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace trilat {
namespace {
constexpr const char* kStudyFormat = "trilat.study";
}

RecordingsStudy parse_recordings_study(const Json& json, const std::string& place,
                                       const std::filesystem::path& folder, const std::string& kind,
                                       const std::function<void(Settings&)>& tell) {
  JsonObject object(json, place, "");
  RecordingsStudy study;
  object.format(kStudyFormat);
  object.choice("kind", {kind});
  study.name = object.text("name");
  if (study.name.empty()) object.refuse("name", "must not be empty");
  if (const std::string campaign = object.text("campaign", ""); !campaign.empty())
    study.campaign = folder / campaign;
  Settings settings(object);
  settings.choice("paper", study.paper, kPaperStudies, kPaperStudyMeaning);
  tell(settings);
  object.about({{"name", "of the study"},
                {"campaign", "folder of recordings, relative to this file; `--campaign` goes first"}});
  object.finish();
  return study;
}

Json resolved_recordings_study(RecordingsStudy study, const std::string& kind,
                               const std::function<void(Settings&)>& tell) {
  Json json{{"format", kStudyFormat}, {"version", 1}, {"kind", kind}, {"name", study.name}};
  Settings settings(json);
  settings.choice("paper", study.paper, kPaperStudies, kPaperStudyMeaning);
  tell(settings);
  return json;
}

std::string unused_name(const std::string& name, std::set<std::string>& used) {
  std::string unused = name;
  for (int number = 2; !used.insert(unused).second; ++number) unused = fmt::format("{} ({})", name, number);
  return unused;
}

Json hashed_inputs(const std::vector<RecordingFile>& files, HashCache& hashes,
                   const std::function<bool()>& stop_requested) {
  Json inputs = Json::array();
  for (const RecordingFile& file : files) {
    const HashedFile hashed = hashes.hash(file.file, stop_requested);
    inputs.push_back({{"take", file.take},
                      {"role", file.role},
                      {"file", file.file.filename().string()},
                      {"bytes", hashed.bytes},
                      {"sha256", hashed.sha256.empty() ? Json() : Json(hashed.sha256)}});
  }
  return inputs;
}

}  // namespace trilat
