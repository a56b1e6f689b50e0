// SPDX-License-Identifier: MIT
#pragma once

#include <exception>
#include <functional>
#include <memory>

#include "recorders/frame_source.h"
#include "recorders/network/agent_options.h"
#include "recorders/network/link/byte_link.h"

namespace trilat {

struct AgentState;

// Carries what a source delivers to the recording machine, over as many connections as it takes. The source
// must stamp arrivals on this machine's steady clock; it is first asked when the recording begins. A live
// source never waits: the oldest frames go when the buffer is full, and are counted.
class AgentLink {
 public:
  AgentLink(FrameSource& source, AgentOptions options, ConnectLink connect);
  ~AgentLink();
  AgentLink(const AgentLink&) = delete;
  AgentLink& operator=(const AgentLink&) = delete;

  // Until the source has ended and all has arrived, the recording machine ends the recording, or stop().
  // Once. Throws InputError where the recording machine refuses this agent before the recording begins. A
  // source that breaks is told there and in the report; what is no InputError of it is thrown then.
  AgentReport run();
  // Takes no more frames, sends what there is and makes run() return. Any thread.
  void stop();
  AgentStatus status() const;

 private:
  void guard(const std::function<void()>& body);
  void pump();
  void take_events();
  void compress();
  AgentEnd keep_connected();
  AgentEnd connect_once(bool& welcomed);
  bool lost_recording() const;
  bool wait_to_retry(std::chrono::milliseconds delay);
  void end_all();

  FrameSource& source_;
  AgentOptions options_;
  ConnectLink connect_;
  std::unique_ptr<AgentState> state_;
  std::exception_ptr source_error_;
  std::exception_ptr thread_error_;  // under the mutex of the state
};

}  // namespace trilat
