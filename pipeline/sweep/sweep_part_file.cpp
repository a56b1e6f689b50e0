// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_part_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "pipeline/sweep/sweep_log.h"

namespace trilat {

SweepPartFile::SweepPartFile(const std::filesystem::path& part, std::size_t buffer_bytes)
    : path_(part / SweepLog::kFinished), buffer_bytes_(buffer_bytes) {}

// False at the end of the file.
bool SweepPartFile::fill() {
  buffer_.erase(0, begin_);
  begin_ = 0;
  std::ifstream file(path_, std::ios::binary);
  if (!file) throw InputError(path_.string(), std::string("cannot be read: ") + std::strerror(errno));
  const std::size_t before = buffer_.size();
  buffer_.resize(before + buffer_bytes_);
  file.seekg(static_cast<std::streamoff>(offset_));
  file.read(buffer_.data() + before, static_cast<std::streamsize>(buffer_bytes_));
  const auto count = static_cast<std::size_t>(file.gcount());
  buffer_.resize(before + count);
  offset_ += count;
  return count > 0;
}

const SweepRecord* SweepPartFile::next() {
  if (record_) return &*record_;
  std::size_t end = buffer_.find('\n', begin_);
  while (end == std::string::npos && fill()) end = buffer_.find('\n', begin_);
  if (end == std::string::npos && begin_ == buffer_.size()) return nullptr;
  const std::string place = fmt::format("{}:{}", path_.string(), ++lines_);
  if (end != std::string::npos) record_ = read_sweep_record(buffer_.substr(begin_, end - begin_), place);
  if (!record_) throw InputError(place, "is damaged; remove this part and run its shard again");
  begin_ = end + 1;
  return &*record_;
}

}  // namespace trilat
