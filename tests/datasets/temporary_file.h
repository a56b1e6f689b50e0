// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <unistd.h>

#include "datasets/base/files.h"

namespace trilat {

// A file with the given text that is gone at the end of the test.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::string_view text) : TemporaryFile() { write_file(path_, text); }
  TemporaryFile() {
    static int count = 0;
    path_ = std::filesystem::path(testing::TempDir()) /
            ("trilat_" + std::to_string(::getpid()) + "_" + std::to_string(++count) + ".csv");
  }
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::string at_line(int line) const { return path_.string() + ":" + std::to_string(line); }

 private:
  std::filesystem::path path_;
};

}  // namespace trilat
