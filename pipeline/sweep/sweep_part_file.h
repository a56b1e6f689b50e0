// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "pipeline/sweep/sweep_record.h"

namespace trilat {

// The records of a part in their order. Between two reads no file is open, so that there may be any number of
// parts.
class SweepPartFile {
 public:
  // `buffer_bytes`: how much is read at once; a longer line still fits.
  SweepPartFile(const std::filesystem::path& part, std::size_t buffer_bytes);

  // The record that comes next, until it is taken; null behind the last. InputError when it is damaged.
  const SweepRecord* next();
  void take() { record_.reset(); }
  const std::filesystem::path& path() const { return path_; }

 private:
  bool fill();

  std::filesystem::path path_;
  std::size_t buffer_bytes_;
  std::string buffer_;
  std::size_t begin_ = 0;     // of what is not read yet, in the buffer
  std::uint64_t offset_ = 0;  // of what is not in the buffer yet, in the file
  std::uint64_t lines_ = 0;
  std::optional<SweepRecord> record_;
};

}  // namespace trilat
