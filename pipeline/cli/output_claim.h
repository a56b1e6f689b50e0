// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace trilat {

// Holds the name of an output that takes long to come, so that no other process takes it meanwhile: the file
// under its unfinished name, empty until somebody writes it. An empty one is removed in the end. InputError
// where that name exists.
class OutputClaim {
 public:
  explicit OutputClaim(const std::filesystem::path& output);
  ~OutputClaim();
  OutputClaim(const OutputClaim&) = delete;
  OutputClaim& operator=(const OutputClaim&) = delete;

 private:
  std::filesystem::path partial_;
};

}  // namespace trilat
