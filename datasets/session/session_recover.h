// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/session/session_reader.h"

namespace trilat {

// Counts of one sensor's rows that were saved, and that were not.
struct SensorRecovery {
  std::string name;
  SensorCounts saved;           // rows in the new file
  std::uint64_t torn_rows = 0;  // written after the last flush, in part
  // Left out, because their stored data are not what was written or cannot be.
  std::uint64_t damaged_body_frames = 0, damaged_depth_frames = 0, damaged_exchanges = 0;
  std::uint64_t damaged_lists = 0;  // of notices or of drop counts, which are left out whole
};

// Copies all that was flushed of a session whose writer was killed into a new, complete session; compressed
// depth is copied byte for byte. The damaged file is only read, and what is damaged in it costs no more than
// itself. `output` appears when all is done. InputError when nothing can be read, or `output` exists.
// `progress` is called with the share done, in [0, 1]; Interrupted when it returns false.
std::vector<SensorRecovery> recover_session(const std::filesystem::path& damaged,
                                            const std::filesystem::path& output,
                                            const std::function<bool(double)>& progress = {});

}  // namespace trilat
