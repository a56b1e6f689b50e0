// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/results/results_file.h"
#include "pipeline/study/hash_cache.h"

namespace trilat {

// Head of a study that reads recordings: its name, what it repeats, and the campaign's folder where its file
// states one.
struct RecordingsStudy {
  std::string name;
  PaperStudy paper = PaperStudy::none;
  std::filesystem::path campaign = {};  // relative to the study's file; may be given on the command line

  static void visit_head(auto& self, Fields& f, StudyKind of) {
    std::size_t kind = 0;
    f.format("trilat.study");
    f.tag("kind", kind, {name_of(of)}, "");
    f("name", self.name, need("Name of the study"));
    if (f.writes_if(false))
      f("campaign", self.campaign,
        opt("Folder of recordings, relative to this file; `--campaign` goes first"));
    f("paper", self.paper, opt(kPaperStudyMeaning));
  }
  void check(const JsonPlace& place) const {
    if (name.empty()) place.at("name").refuse("must not be empty");
  }
};

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
