// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "datasets/session/session_types.h"
#include "recorders/link/byte_stream.h"
#include "recorders/link/messages.h"

namespace trilat {

struct SenderOptions {
  std::string name;                              // of the agent
  std::uint64_t run = 0;                         // any number, but another one for each run of the agent
  std::chrono::milliseconds idle_timeout{5000};  // without a word of the recorder, the connection is given up
  std::chrono::milliseconds min_retry_delay{100}, last_retry{2000};  // doubled in between
  std::chrono::milliseconds exchange_period{250};                    // of clock stamps
  // Lost, back, refused for now: a line for a person. Any thread.
  std::function<void(const std::string&)> on_status_change = [](const std::string&) {};
  // Any thread.
  std::function<void(const ClockExchange&)> on_exchange = [](const ClockExchange&) {};
};

// A log that is sent while it is written. The numbers are asked by the sender's thread.
struct SentLog {
  std::filesystem::path path;
  std::uint64_t id = 0, recording = 0;
  std::function<std::uint64_t()> written_bytes;  // may be read from the file
  std::function<std::uint64_t()> frames;         // in all of the log so far
};

// Carries a log to the recorder over as many connections as it takes, always from the byte on that the
// recorder names, and exchanges clock stamps with it on a connection of their own. What the recorder
// acknowledged is on its disk.
class AgentSender {
 public:
  AgentSender(SenderOptions options, Connect connect);
  ~AgentSender();
  AgentSender(const AgentSender&) = delete;
  AgentSender& operator=(const AgentSender&) = delete;

  // Id of the recording that the recorder asks for; 0 before it has begun. Another than that of the log that
  // is sent means that the recording of that log is gone.
  std::uint64_t recording() const { return recording_; }
  void send(SentLog log);
  // Newest bodies, shown while the log is far behind.
  void show(std::uint8_t sensor, const BodyFrame& frame);

  bool stop_asked() const { return stop_asked_; }  // the recorder wants no more frames
  std::uint64_t acknowledged() const { return acknowledged_; }
  bool connected() const { return connected_; }
  // Why the recorder will never take this agent; empty where it may.
  std::string refusal() const;

 private:
  using Clock = std::chrono::steady_clock;
  void keep_connected();
  bool serve(ByteStream& stream);
  std::uint64_t wait_for_welcome(ByteStream& stream, MessageReader& reader,
                                 const std::optional<SentLog>& log);
  void take(const Message& message);
  void receive(ByteStream& stream, MessageReader& reader, std::chrono::milliseconds at_most);
  void keep_exchanging();
  void exchange_stamps(ByteStream& stream);
  bool pause(std::chrono::milliseconds duration);
  std::optional<SentLog> log() const;

  SenderOptions options_;
  Connect connect_;
  mutable std::mutex mutex_;
  std::optional<SentLog> log_;
  std::optional<LiveMessage> live_;
  std::string refusal_;
  std::atomic<std::uint64_t> recording_{0}, acknowledged_{0};
  std::atomic<bool> ended_{false}, stop_asked_{false}, connected_{false};
  Clock::time_point heard_ = Clock::now();  // of the sending thread
  std::thread sending_, exchanging_;        // the last: they use all of the above
};

}  // namespace trilat
