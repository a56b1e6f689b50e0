// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace trilat {

// What the file system says of a file without reading it.
struct FileIdentity {
  std::string written;  // device, number, size and when it was last written: another, another content
  std::string changed;  // the same, and when its name, links or rights last changed
  std::uintmax_t bytes = 0;
  std::int64_t changed_s = 0;  // the later of both times
};

// Nothing when it is no file or cannot be looked at.
std::optional<FileIdentity> identity_of(const std::filesystem::path& file);

// FileIdentity::written; empty when there is none.
std::string when_written(const std::filesystem::path& file);

// Files that must stay as they are while something is computed from them: what came of two contents belongs
// to neither.
class WatchedFiles {
 public:
  WatchedFiles() = default;
  explicit WatchedFiles(const std::vector<std::filesystem::path>& files);
  // Before the file is read for the first time.
  void add(const std::filesystem::path& file);
  // Whether one was written or replaced since it was added.
  bool changed() const;
  // InputError when it was.
  void check() const;

 private:
  struct Watched {
    std::filesystem::path file;
    std::string written;
  };
  std::vector<Watched> files_;
};

}  // namespace trilat
