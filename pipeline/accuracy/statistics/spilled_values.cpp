// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/spilled_values.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <unistd.h>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::uint64_t kFewestTogether = 256, kMostTogether = 8192;
constexpr std::uint64_t kBuffersShare = 4;  // one part of so many of the memory is for what is being filled

[[noreturn]] void refuse(const std::filesystem::path& folder, const char* what) {
  throw OutputError(folder.string(), std::string(what) + ": " + std::strerror(errno));
}

int open_nameless(const std::filesystem::path& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0) return file;
  std::string name = (folder / "distances-XXXXXX").string();  // where the file system knows no such files
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named < 0) refuse(folder, "a file for distances cannot be made");
  ::unlink(name.c_str());
  return named;
}

}  // namespace

SpilledValues::SpilledValues(std::size_t groups, std::filesystem::path folder, std::uint64_t memory_bytes,
                             std::size_t threads)
    : folder_(std::move(folder)), groups_(groups) {
  const std::uint64_t values = memory_bytes / sizeof(double);
  const std::uint64_t buffers = std::max<std::uint64_t>(1, groups * threads);
  chunk_ = std::clamp(values / kBuffersShare / buffers, kFewestTogether, kMostTogether);
  may_keep_ = values - values / kBuffersShare;
}

SpilledValues::~SpilledValues() {
  if (file_ >= 0) ::close(file_);
}

void SpilledValues::Writer::finish() {
  for (std::size_t group = 0; group < buffers_.size(); ++group)
    if (!buffers_[group].empty()) {
      buffers_[group].shrink_to_fit();
      values_.store(group, buffers_[group]);
    }
}

// Leaves the buffer empty.
void SpilledValues::store(std::size_t group, std::vector<double>& buffer) {
  Extent extent{0, buffer.size()};
  {
    const std::lock_guard lock(mutex_);
    if (buffer.size() <= may_keep_) {
      may_keep_ -= buffer.size();
      groups_[group].kept.push_back(std::move(buffer));
      buffer = {};
      return;
    }
    if (file_ < 0) file_ = open_nameless(folder_);
    extent.first = in_file_;
    in_file_ += extent.count;
  }
  spill(extent, buffer);
  buffer.clear();
  const std::lock_guard lock(mutex_);
  groups_[group].spilled.push_back(extent);
}

void SpilledValues::spill(const Extent& extent, const std::vector<double>& buffer) {
  const char* bytes = reinterpret_cast<const char*>(buffer.data());
  for (std::uint64_t done = 0, all = extent.count * sizeof(double); done < all;) {
    const auto at = static_cast<off_t>(extent.first * sizeof(double) + done);
    const ssize_t wrote = ::pwrite(file_, bytes + done, all - done, at);
    if (wrote < 0 && errno != EINTR) refuse(folder_, "the file for distances cannot be written");
    done += static_cast<std::uint64_t>(std::max<ssize_t>(wrote, 0));
  }
}

void SpilledValues::read(const Extent& extent, std::vector<double>& values) const {
  values.resize(extent.count);
  char* bytes = reinterpret_cast<char*>(values.data());
  for (std::uint64_t done = 0, all = extent.count * sizeof(double); done < all;) {
    const auto at = static_cast<off_t>(extent.first * sizeof(double) + done);
    const ssize_t got = ::pread(file_, bytes + done, all - done, at);
    if (got == 0) errno = EIO;  // it is shorter than what was written
    if (got <= 0 && errno != EINTR) refuse(folder_, "the file for distances cannot be read");
    done += static_cast<std::uint64_t>(std::max<ssize_t>(got, 0));
  }
}

}  // namespace trilat
