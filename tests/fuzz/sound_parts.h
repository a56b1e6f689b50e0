// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/content_hash.h"

namespace trilat {

// What of a file is fuzzed: all of it, or all before the hash that it ends with.
enum class Fuzzed { whole, before_hash };

// A file of a part folder, as our own writer made it.
struct SoundPartFile {
  std::string folder, name;
  Fuzzed fuzzed = Fuzzed::whole;
};

inline const std::vector<SoundPartFile> kSoundPartFiles{
    {"accuracy", "part.json"},
    {"accuracy", "items/takes/p01-walking/item.json"},
    {"accuracy", "hashes.json"},
    {"sweep", "part.json"},
    {"sweep", "items/trials/r1-c1-1/item.json"},
    {"recording", "part.json"},
    {"recording", "items/clocks/network-0/item.json"},
    {"calibration", "part.json"},
    {"calibration", "items/wand/unit-0/item.json"},
    {"calibration", "items/rigs/run-0/item.json"},
    {"accuracy", "items/takes/p01-walking/summary.bin", Fuzzed::before_hash}};

inline std::string fuzzed_text_in(const SoundPartFile& file, const std::string& text) {
  return file.fuzzed == Fuzzed::whole ? text : text.substr(0, text.size() - hash_of_text("").size());
}

// What stands in the file when that text is fuzzed; hashes are of the new text.
inline std::string replaced_in(const SoundPartFile& file, const std::string& text) {
  return file.fuzzed == Fuzzed::before_hash ? text + hash_of_text(text) : text;
}

}  // namespace trilat
