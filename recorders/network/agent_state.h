// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>

#include "recorders/network/agent_link.h"
#include "recorders/network/link/message_link.h"
#include "recorders/network/resend_ring.h"

namespace trilat {

// What the threads of an agent share; all of it under `mutex`.
struct AgentState {
  AgentState(std::size_t sensors, std::size_t ring_bytes, bool may_drop)
      : ring(sensors, ring_bytes, may_drop) {}

  std::mutex mutex;
  std::condition_variable changed;
  ResendRing ring;
  bool welcomed = false;                   // on the present connection
  bool begun = false;                      // `recording` has asked for frames
  bool stopping = false;                   // no more frames are wanted
  bool over = false;                       // every thread is to end
  std::optional<std::uint64_t> recording;  // that this run belongs to
  std::optional<std::chrono::steady_clock::time_point> source_ended;
  std::chrono::steady_clock::time_point last_connected{};
  MessageLink* link = nullptr;  // to wake, while connected
  AgentStatus status;
  std::function<void()> stop;  // ends the source; without the mutex
};

// The recording machine has begun another recording than the one that this run took part in: what that one
// lacks is lost, and what comes until the other one begins is nobody's. Under the mutex.
void abandon_recording(AgentState& state);

// Sends what the ring holds and takes acknowledgements until there is nothing left to do; throws LinkLost and
// LinkRefused.
AgentEnd serve_agent_link(AgentState& state, MessageLink& link, const HelloMessage& hello);

// Answers the recording machine's pings with this machine's steady clock, on connections of its own, until
// state.over.
void answer_clock_pings(AgentState& state, const AgentOptions& options, const ConnectLink& connect);

}  // namespace trilat
