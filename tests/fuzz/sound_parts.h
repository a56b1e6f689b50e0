// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/content_hash.h"

namespace trilat {

// What of a file is fuzzed: all of it, the document in its first line, behind the hash that lines of journals
// begin with, or all before the hash that it ends with.
enum class Fuzzed { whole, first_line, before_hash };

// A file of a part folder, as our own writer made it.
struct SoundPartFile {
  std::string folder, name;
  Fuzzed fuzzed = Fuzzed::whole;
};

inline const std::vector<SoundPartFile> kSoundPartFiles{
    {"accuracy", "part.json"},
    {"accuracy", "items.json"},
    {"accuracy", "hashes.json"},
    {"sweep", "part.json"},
    {"sweep", "sums.jsonl", Fuzzed::first_line},
    {"recording", "part.json"},
    {"recording", "items.json"},
    {"calibration", "part.json"},
    {"calibration", "items.json"},
    {"accuracy", "items.jsonl", Fuzzed::first_line},
    {"accuracy/takes/p01-walking", "summary.bin", Fuzzed::before_hash}};

inline std::string fuzzed_text_in(const SoundPartFile& file, const std::string& text) {
  if (file.fuzzed == Fuzzed::first_line)
    return text.substr(text.find(' ') + 1, text.find('\n') - text.find(' ') - 1);
  return file.fuzzed == Fuzzed::whole ? text : text.substr(0, text.size() - hash_of_text("").size());
}

// The file with that text in place of its own; hashes are of the new text.
inline std::string replaced_in(const SoundPartFile& file, const std::string& sound, const std::string& text) {
  if (file.fuzzed == Fuzzed::before_hash) return text + hash_of_text(text);
  if (file.fuzzed == Fuzzed::whole) return text;
  const std::size_t end = sound.find('\n');
  return hash_of_text(text) + ' ' + text + (end == std::string::npos ? "\n" : sound.substr(end));
}

}  // namespace trilat
