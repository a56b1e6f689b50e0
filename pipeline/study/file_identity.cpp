// SPDX-License-Identifier: MIT
#include "pipeline/study/file_identity.h"

#include <algorithm>

#include <fmt/format.h>
#include <sys/stat.h>

#include "datasets/base/error.h"

namespace trilat {

std::optional<FileIdentity> identity_of(const std::filesystem::path& file) {
  struct stat s;
  if (::stat(file.c_str(), &s) != 0 || !S_ISREG(s.st_mode)) return std::nullopt;
  const auto time = [](const timespec& t) { return fmt::format("{}.{:09}", t.tv_sec, t.tv_nsec); };
  FileIdentity identity;
  identity.written = fmt::format("{}:{}:{}:{}", s.st_dev, s.st_ino, s.st_size, time(s.st_mtim));
  identity.changed = identity.written + ':' + time(s.st_ctim);
  identity.bytes = static_cast<std::uintmax_t>(s.st_size);
  identity.changed_s = std::max<std::int64_t>(s.st_mtim.tv_sec, s.st_ctim.tv_sec);
  return identity;
}

std::string when_written(const std::filesystem::path& file) {
  const auto identity = identity_of(file);
  return identity ? identity->written : "";
}

WatchedFiles::WatchedFiles(const std::vector<std::filesystem::path>& files) {
  for (const std::filesystem::path& file : files) add(file);
}

void WatchedFiles::add(const std::filesystem::path& file) { files_.push_back({file, when_written(file)}); }

bool WatchedFiles::changed() const {
  return std::any_of(files_.begin(), files_.end(),
                     [](const Watched& watched) { return when_written(watched.file) != watched.written; });
}

void WatchedFiles::check() const {
  for (const Watched& watched : files_)
    if (when_written(watched.file) != watched.written)
      throw InputError(watched.file.string(), "changed while it was being evaluated; run again");
}

}  // namespace trilat
