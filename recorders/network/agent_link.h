// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>

#include "datasets/hdf5/chunk_codec.h"
#include "recorders/frame_source.h"
#include "recorders/network/link/byte_link.h"

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
  ended_by_server,  // the recording is over; frames that were still buffered are counted as lost
  abandoned,        // the recording is gone without an end, and the source has nothing left for another
  unacknowledged,   // the recording machine did not answer for too long
};

struct AgentReport {
  AgentEnd end = AgentEnd::unacknowledged;
  std::string source_problem;  // why the source broke; empty where it ended
  AgentStatus status;
};

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
