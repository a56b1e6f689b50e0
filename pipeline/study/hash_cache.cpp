// SPDX-License-Identifier: MIT
#include "pipeline/study/hash_cache.h"

#include <algorithm>
#include <ctime>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "datasets/base/document.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

constexpr const char* kFile = "hashes.json";
constexpr std::int64_t kSettled_s = 2;

struct HashesFile {
  std::map<std::string, std::string> files;  // SHA-256 by identity

  static void fields(auto& self, auto&& f) {
    f.format("trilat.hashes");
    f("files", self.files);
  }
};

}  // namespace

void HashCache::load(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kFile;
  if (!std::filesystem::exists(path)) return;
  try {
    sha256_ = read_as<HashesFile>(read_json(path), path).files;
  } catch (const InputError&) {
    return;  // damaged: then files are hashed again
  }
}

HashedFile HashCache::hash(const std::filesystem::path& file, const std::function<bool()>& stop_requested) {
  const auto before = identity_of(file);
  if (!before) return {};
  {
    const std::lock_guard lock(mutex_);
    if (const auto known = sha256_.find(before->changed); known != sha256_.end())
      return {known->second, before->bytes};
  }
  const std::int64_t now_s = std::time(nullptr);
  try {
    const std::string sha256 = hash_of_file(file, stop_requested);
    const auto after = identity_of(file);
    if (after && after->changed == before->changed && after->changed_s + kSettled_s <= now_s) {
      const std::lock_guard lock(mutex_);
      sha256_[before->changed] = sha256;
    }
    return {sha256, before->bytes};
  } catch (const InputError&) {
    return {};
  }
}

void HashCache::save(const std::filesystem::path& folder) const {
  const std::lock_guard lock(mutex_);
  write_file(folder / kFile, json_text(json_of(HashesFile{sha256_}), 1) + "\n");
}

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
  return std::ranges::any_of(
      files_, [](const Watched& watched) { return when_written(watched.file) != watched.written; });
}

void WatchedFiles::check() const {
  for (const Watched& watched : files_)
    if (when_written(watched.file) != watched.written)
      throw InputError(watched.file.string(), "changed while it was being evaluated; run again");
}

}  // namespace trilat
