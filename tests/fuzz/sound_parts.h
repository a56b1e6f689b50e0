// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/files.h"

namespace trilat {

// A JSON document of a part folder, as our own writer made it: a whole file, or its first line behind the
// hash that lines of journals begin with.
struct SoundPartFile {
  std::string folder, name;
  bool is_line = false;
};

inline const std::vector<SoundPartFile> kSoundPartFiles{
    {"accuracy", "part.json"},        {"accuracy", "items.json"},    {"accuracy", "hashes.json"},
    {"sweep", "part.json"},           {"sweep", "sums.jsonl", true}, {"recording", "part.json"},
    {"recording", "items.json"},      {"calibration", "part.json"},  {"calibration", "items.json"},
    {"accuracy", "items.jsonl", true}};

inline std::string json_in(const SoundPartFile& file, const std::string& text) {
  return file.is_line ? text.substr(text.find(' ') + 1, text.find('\n') - text.find(' ') - 1) : text;
}

}  // namespace trilat
