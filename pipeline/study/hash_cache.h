// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace trilat {

struct HashedFile {
  std::string sha256;  // empty when the file cannot be read
  std::uintmax_t bytes = 0;
};

// Hashes of files, remembered by what the file system says of them (device, number, size, times of the last
// change), so that terabytes are not read again to learn that nothing changed. A file that changed within the
// last two seconds before it was hashed is not remembered: it could change again without a later time.
class HashCache {
 public:
  // Adds what an earlier output remembers (hashes.json); nothing where it has no such file or a damaged one.
  void load(const std::filesystem::path& folder);
  // From any thread. Interrupted when asked to stop.
  HashedFile hash(const std::filesystem::path& file, const std::function<bool()>& stop_requested);
  // hashes.json (trilat.hashes, version 1): of this machine, so not part of what equal runs have in common.
  void save(const std::filesystem::path& folder) const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::string> sha256_;  // by identity
};

// Identity of a file by the file system, without reading it.
struct FileIdentity {
  std::string written;  // device, number, size and when it was last written: another, another content
  std::string changed;  // the same, and when its name, links or rights last changed
  std::uintmax_t bytes = 0;
  std::int64_t changed_s = 0;  // the later of both times
};

// Identity of a file; nothing when it is not a regular file or cannot be looked at.
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
