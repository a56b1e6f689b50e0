// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <unistd.h>

namespace trilat {

// A folder of this process's own, removed with everything in it.
class FuzzFolder {
 public:
  explicit FuzzFolder(const std::string& name)
      : path_(std::filesystem::temp_directory_path() / ("trilat_fuzz_" + name + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~FuzzFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  FuzzFolder(const FuzzFolder&) = delete;
  FuzzFolder& operator=(const FuzzFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  // The sound results, or a folder of them, are copied here.
  std::filesystem::path with_sound(const std::string& name = {}) const {
    const char* sound = std::getenv("TRILAT_SOUND_RESULTS");
    if (!sound) std::abort();
    std::filesystem::copy(std::filesystem::path(sound) / name, path_ / name,
                          std::filesystem::copy_options::recursive);
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

inline void put(const std::filesystem::path& file, std::string_view text) {
  std::ofstream(file, std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
}

}  // namespace trilat
