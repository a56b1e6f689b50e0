// SPDX-License-Identifier: MIT
#include "pipeline/study/recordings.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace trilat {
std::string unused_name(const std::string& name, std::set<std::string>& used) {
  std::string unused = name;
  for (int number = 2; !used.insert(unused).second; ++number) unused = fmt::format("{} ({})", name, number);
  return unused;
}

Json hashed_inputs(const std::vector<RecordingFile>& files, HashCache& hashes,
                   const std::function<bool()>& stop_requested) {
  Json inputs = Json::array();
  for (const RecordingFile& file : files) {
    const HashedFile hashed = hashes.hash(file.file, stop_requested);
    inputs.push_back({{"take", file.take},
                      {"role", file.role},
                      {"file", file.file.filename().string()},
                      {"bytes", hashed.bytes},
                      {"sha256", hashed.sha256.empty() ? Json() : Json(hashed.sha256)}});
  }
  return inputs;
}

}  // namespace trilat
