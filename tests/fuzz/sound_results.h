// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace trilat {

// Computes a tiny study of every kind into folders inside `scratch`.
void write_sound_results(const std::filesystem::path& scratch);

// One JSON file of a results folder, as our own writer made it.
struct SoundFile {
  std::filesystem::path folder;
  std::string name;
  std::string text;
};

// All in the folders inside `results`, in an order that is always the same.
std::vector<SoundFile> sound_files(const std::filesystem::path& results);

}  // namespace trilat
