// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "datasets/base/files.h"

namespace trilat {

// One JSON file of a results folder, as our own writer made it.
struct SoundFile {
  std::filesystem::path folder;
  std::string name;
  std::string text;
};

// All in the folders inside `results`, in an order that is always the same.
inline std::vector<SoundFile> sound_files(const std::filesystem::path& results) {
  std::vector<SoundFile> files;
  for (const char* folder :
       {"accuracy", "budget", "calibration", "gate", "recording", "sensitivity", "sweep"})
    for (const auto& entry : std::filesystem::directory_iterator(results / folder))
      if (entry.path().extension().string().starts_with(".json"))
        files.push_back({results / folder, entry.path().filename().string(), read_file(entry.path())});
  std::ranges::sort(files, [](const SoundFile& a, const SoundFile& b) {
    return std::pair(a.folder, a.name) < std::pair(b.folder, b.name);
  });
  return files;
}

}  // namespace trilat
