// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "datasets/hdf5/chunk_codec.h"

namespace trilat {

struct AgentOptions {
  std::string name;
  std::uint64_t incarnation = 0;  // any number, but another one for each run of the agent
  std::size_t ring_bytes = std::size_t{256} << 20;
  ChunkCompression compression = quickest_compression();
  std::chrono::milliseconds silence_limit{5000};
  std::chrono::milliseconds first_retry{100}, last_retry{2000};  // doubled in between
  // How long the end of the source may wait for a recording machine that does not answer.
  std::chrono::milliseconds farewell_limit{30000};
  // Lost, back, refused: a line for a person. Called by one thread.
  std::function<void(const std::string& news)> on_news = [](const std::string&) {};
};

struct AgentStatus {
  bool connected = false;
  bool recording = false;  // the recording machine has asked for frames
  std::uint64_t frames_taken = 0;
  std::uint64_t frames_lost = 0;
  std::uint64_t recordings_abandoned = 0;  // the recording machine began another one before their end
  std::uint64_t reconnections = 0;
  std::size_t buffered_bytes = 0;
};

enum class AgentEnd {
  complete,         // the source has ended and everything has arrived, but for what was lost
  ended_by_server,  // the recording is over; what was still buffered is nobody's loss
  abandoned,        // the recording is gone without an end, and the source has nothing left for another
  unacknowledged,   // the recording machine did not answer for too long
};

struct AgentReport {
  AgentEnd end = AgentEnd::unacknowledged;
  std::string source_problem;  // why the source broke; empty where it ended
  AgentStatus status;
};

}  // namespace trilat
