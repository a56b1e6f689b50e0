// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "datasets/base/settings.h"
#include "datasets/results/results_file.h"
#include "pipeline/study/hash_cache.h"

namespace trilat {

// Head of a study that reads recordings: its name, what it repeats, and the campaign's folder where its file
// states one.
struct RecordingsStudy {
  std::string name;
  PaperStudy paper = PaperStudy::none;
  std::filesystem::path campaign = {};  // relative to the study's file; may be given on the command line
};

// Reads the head of a document of that kind, and what `tell` says of its other settings. InputError at
// `place`.
RecordingsStudy parse_recordings_study(const Json& json, const std::string& place,
                                       const std::filesystem::path& folder, const std::string& kind,
                                       const std::function<void(Settings&)>& tell);
// Every setting written out, defaults included; the campaign is not one.
Json resolved_recordings_study(RecordingsStudy study, const std::string& kind,
                               const std::function<void(Settings&)>& tell);

// A file that a study reads, and what it is of which take or recording.
struct RecordingFile {
  std::string take, role;
  std::filesystem::path file;
};

// The name, or "NAME (2)" and so on where `used` has it; `used` has the result then.
std::string unused_name(const std::string& name, std::set<std::string>& used);

// The files as inputs of a manifest, each with its bytes and hash.
Json hashed_inputs(const std::vector<RecordingFile>& files, HashCache& hashes,
                   const std::function<bool()>& stop_requested);

}  // namespace trilat
