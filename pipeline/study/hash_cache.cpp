// SPDX-License-Identifier: MIT
#include "pipeline/study/hash_cache.h"

#include <ctime>

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"
#include "pipeline/study/file_identity.h"

namespace trilat {
namespace {

constexpr const char* kFile = "hashes.json";
constexpr const char* kFormat = "trilat.hashes";
constexpr std::int64_t kSettled_s = 2;

}  // namespace

void HashCache::load(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kFile;
  if (!std::filesystem::exists(path)) return;
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  check_format(object, kFormat, 1);
  JsonObject files = object.object("files");
  for (const std::string& identity : files.keys()) sha256_[identity] = files.text(identity);
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
  Json files = Json::object();
  for (const auto& [identity, sha256] : sha256_) files[identity] = sha256;
  write_file(folder / kFile, json_text({{"format", kFormat}, {"version", 1}, {"files", files}}, 1) + "\n");
}

}  // namespace trilat
