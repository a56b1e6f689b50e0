// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/document.h"

namespace trilat {

// An output that a verb is about to write.
struct OutputRequest {
  std::filesystem::path path;
  std::vector<std::filesystem::path> inputs;  // files and folders that the verb reads; empty ones are none
  bool force = false;                         // what else lies there may be replaced
  std::string aside = ".partial";             // behind a file's name while it is unfinished
};

// Mark of an output folder: its run.json names the verb that wrote it and its inputs.
struct OutputMark {
  std::string verb;
  std::vector<std::string> names;  // of the study or the simulated campaign; of a report all its studies
  std::string campaign = {};       // whose takes a study evaluates

  static void fields(auto& self, auto&& f) {
    f("verb", self.verb, "names", self.names, "campaign", self.campaign);
  }
};

// The rule for outputs, asked before anything is written: a folder has to be absent, empty, or marked as of
// the same verb, of a common name and of the same campaign, unless `force`. InputError else; where it is an
// input, a link to one, in one or around one, whatever is forced; and where it cannot be written at all.
void check_output_folder(const OutputRequest& output, const OutputMark& mark);
// Marks the folder, which is made where there is none.
void mark_output(const std::filesystem::path& folder, const OutputMark& mark);

// Checks an output file, which has to be absent, unless `force` or the verb knows it as its own.
void check_output_file(const OutputRequest& output, bool is_own = false);

// Whether a file is not there, is empty, or begins with a text that has `part`.
bool begins_with(const std::filesystem::path& file, const std::string& part);

}  // namespace trilat
