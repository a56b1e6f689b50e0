// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>

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
  // Adds what an earlier output remembers (hashes.json); nothing where it has no such file.
  void load(const std::filesystem::path& folder);
  // From any thread. Interrupted when asked to stop.
  HashedFile hash(const std::filesystem::path& file, const std::function<bool()>& stop_requested);
  // hashes.json (trilat.hashes, version 1): of this machine, so not part of what equal runs have in common.
  void save(const std::filesystem::path& folder) const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::string> sha256_;  // by identity
};

}  // namespace trilat
