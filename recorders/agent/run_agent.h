// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "recorders/agent/agent_sender.h"
#include "recorders/spool.h"

namespace trilat {

struct AgentOptions {
  std::string name;
  std::filesystem::path folder = ".";  // of its logs
  Connect connect;                     // to the recorder; none: it records alone, until it is stopped
  SpoolOptions spool = {};
  std::uint64_t reserve_bytes = std::uint64_t{256} << 20;  // of the disk
  // How long the end may wait for a recorder that takes nothing.
  std::chrono::milliseconds shutdown_timeout{30000};
  SenderOptions link = {};
  std::function<bool()> stop_requested = [] { return false; };
  std::function<void(const std::string&)> on_status_change = [](const std::string&) {
  };  // a line for a person; any thread
};

// A log that stays on the agent's disk, as the recorder does not have all of it.
struct LeftLog {
  std::filesystem::path path;
  std::uint64_t unsent_bytes = 0;
};

struct AgentReport {
  std::uint64_t frames = 0;  // in its logs
  std::int64_t lost_at_source = 0, lost_in_queue = 0;
  std::string source_problem;  // why the source broke; empty where it ended
  std::vector<LeftLog> left;   // without those that all arrived
  bool was_recorded = false;   // a recording began
  bool whole() const;          // nothing was lost, and all arrived
};

// Records what the source delivers into a log of its own and sends that, until the source ends, the recorder
// wants no more, or it is asked to stop. What the recorder has all of is removed. InputError where the
// recorder refuses this agent; OutputError where the disk fails.
AgentReport run_agent(const std::vector<std::unique_ptr<FrameSource>>& source, const AgentOptions& options);

}  // namespace trilat
