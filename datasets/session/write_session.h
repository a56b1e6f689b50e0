// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/session/event_log.h"

namespace trilat {

struct LogInput {
  std::filesystem::path path;
  std::int64_t missing_frames = 0;  // known to have been delivered behind its end
};

// Counts of what came from the logs into the session, of one sensor.
struct SensorWritten {
  std::string name;
  std::uint64_t body_frames = 0, depth_frames = 0, clock_exchanges = 0;
  std::uint64_t left_out = 0;  // frames whose times no clock shows, or whose depth cannot be decompressed
  DropCount drops;             // running total, with the frames between two logs and behind the last one
};

struct LogsWritten {
  std::vector<LogSummary> logs;  // in the order of their beginning
  std::vector<SensorWritten> sensors;
  bool whole()
      const;  // no byte of a log was damaged or cut, no frame left out, and each log was ended in order
};

// Makes session.h5 of event logs; depth chunks are copied as they are. A sensor of an agent bears the agent's
// name, with -1, -2 … behind where it has several. Logs of one agent, or of one recording, are joined sensor
// by sensor, and what was not recorded between them counts as lost. What is damaged costs no more than
// itself, and each sensor of its log has a notice of it. `progress` is called with the share done;
// Interrupted when it returns false. InputError for a log that is none, is still being written or is given
// twice, for logs of one sensor that overlap, for two sensors of one name, and when `output` cannot be
// written; the logs are only read.
LogsWritten write_session(const std::vector<LogInput>& logs, const std::filesystem::path& output,
                          const std::function<bool(double)>& progress = {});

// write_session(), then reads all that it wrote, and removes the logs where all is there. `left`: why the
// logs were left where they are; empty when they are gone.
LogsWritten close_recording(const std::vector<LogInput>& logs, const std::filesystem::path& output,
                            std::string& left, const std::function<bool(double)>& progress = {});

}  // namespace trilat
