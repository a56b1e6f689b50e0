// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/session/event_log.h"

namespace trilat {

// What of one sensor came from the logs into the session.
struct SensorWritten {
  std::string name;
  std::uint64_t body_frames = 0, depth_frames = 0, clock_exchanges = 0;
  std::uint64_t left_out = 0;  // frames whose times no clock shows, or whose depth cannot be decompressed
  DropCount drops;             // the last that was counted
};

struct LogsWritten {
  std::vector<LogSummary> logs;  // in the order in which they were given
  std::vector<SensorWritten> sensors;
  bool whole()
      const;  // no byte of a log was damaged or cut, no frame left out, and each log was ended in order
};

// Makes session.h5 of event logs, the sensors of one behind those of the other; depth chunks are copied as
// they are. What is damaged costs no more than itself, and each sensor of its log has a notice of it.
// `progress` is called with the share done; Interrupted when it returns false. InputError for a log that is
// none, is still being written or is given twice, for two sensors of one name, and when `output` cannot be
// written; the logs are only read.
LogsWritten write_session(const std::vector<std::filesystem::path>& logs, const std::filesystem::path& output,
                          const std::function<bool(double)>& progress = {});

// write_session(), then reads all that it wrote, and removes the logs where all is there. Why the logs were
// left where they are; empty when they are gone.
std::string close_recording(const std::vector<std::filesystem::path>& logs,
                            const std::filesystem::path& output,
                            const std::function<bool(double)>& progress = {});

}  // namespace trilat
