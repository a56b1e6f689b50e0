// SPDX-License-Identifier: MIT
#include "pipeline/take_folder.h"

#include "pipeline/replay_take.h"

namespace trilat {

std::filesystem::path own_folder(const std::filesystem::path& output, const std::string& take) {
  return output / kTakesFolder / take;
}

std::filesystem::path folder_of_take(const std::filesystem::path& output, const std::string& take) {
  const std::filesystem::path own = own_folder(output, take);
  return std::filesystem::is_directory(own) ? own : output;
}

bool holds_take(const Plan& plan, std::size_t take, const std::filesystem::path& output) {
  const std::filesystem::path folder = folder_of_take(output, plan.takes[take].take.id);
  return std::filesystem::exists(folder / "samples.h5") &&
         (!is_replayed(plan, take) || std::filesystem::exists(folder / "replay.h5"));
}

}  // namespace trilat
