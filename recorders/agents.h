// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "datasets/session/event_log.h"
#include "datasets/session/write_session.h"
#include "recorders/link/byte_stream.h"
#include "recorders/link/messages.h"
#include "recorders/spool.h"

namespace trilat {

struct AgentsOptions {
  std::size_t count = 0;                         // the recording begins when so many are there
  std::filesystem::path session;                 // copies of their logs lie beside it
  std::uint64_t recording = 0;                   // id of the recording
  double silence_s = 1.5;                        // without frames for so long, a sensor is reported as silent
  std::chrono::milliseconds idle_timeout{5000};  // without a word, a connection is given up
  std::chrono::milliseconds drain_timeout{
      10000};  // without progress, agents are no longer waited for at the end
};

// Places of the socket by which `trilat receive` reaches this user's recorder, which listens at the first.
std::vector<std::filesystem::path> receive_sockets();

// Name of the copy of an agent's log beside the session that it is to become part of.
std::filesystem::path copy_name(const std::filesystem::path& session, const std::string& agent,
                                std::uint64_t log);

// Agents of a recording: takes their connections, puts their logs on the disk byte for byte, and says how far
// these are.
class Agents {
 public:
  Agents(std::unique_ptr<StreamListener> listener, AgentsOptions options);
  ~Agents();
  Agents(const Agents&) = delete;
  Agents& operator=(const Agents&) = delete;

  // Names of those that are there.
  std::vector<std::string> names() const;
  bool all_there() const { return names().size() >= options_.count; }
  // From now on frames are wanted.
  void begin() { begun_ = true; }
  // Reports which sensors are silent; a few times a second.
  void look_after();
  std::vector<SensorStatus> status(double period_s);
  std::vector<std::string> take_notices();
  // True once every agent has ended its log and all of it is on this disk.
  bool all_done() const;
  // Frames are no longer wanted: waits for what agents still hold, as long as it comes.
  void drain();
  // The logs that were received, and what is missing of each.
  std::vector<LogInput> logs() const;
  std::string disk_problem() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Copy {  // of one log of an agent
    std::filesystem::path path;
    std::uint64_t id = 0;
    std::shared_ptr<AppendFile> file;
    std::unique_ptr<LogScanner> scanner;
    std::uint64_t size = 0, synced = 0, frames_held = 0;
    bool has_ended = false, done = false;  // the log has come to its end; and it is on the disk
    bool is_resumed = false;               // an earlier recorder began it
  };
  struct Sensor {
    std::uint64_t body_frames = 0, depth_frames = 0, at_last_status = 0;
    Clock::time_point heard = Clock::now();
    bool silent = false;
    DropCount drops{};
    std::optional<BodyFrame> newest{};
  };
  struct Agent {
    std::uint64_t run = 0, connection = 0;  // of its process; number of the present connection, 0: none
    Clock::time_point heard{};
    std::vector<SensorDescription> descriptions;
    std::vector<Sensor> sensors;
    std::list<Copy> copies;  // of the logs of its runs
  };
  struct Connection {
    std::thread thread;
    std::atomic<bool> done{false};
  };

  void accept_all();
  void serve(ByteStream& stream);
  void answer_pings(ByteStream& stream, MessageReader& reader);
  std::uint64_t enter(const HelloMessage& hello);
  Copy& copy_of(Agent& agent, const std::string& name, std::uint64_t log);
  void open_copy(Agent& agent, Copy& copy, const std::string& name, std::uint64_t log);
  static void set_sensors(Agent& agent, const std::vector<SensorDescription>& sensors);
  void receive(ByteStream& stream, MessageReader& reader, const HelloMessage& hello, std::uint64_t number);
  void take(Agent& agent, Copy& copy, const Message& message);
  void sync_and_acknowledge(ByteStream& stream, Agent& agent, Copy* copy, std::uint64_t number,
                            Clock::time_point& acknowledged);
  void count(Agent& agent, std::size_t sensor, const LogEvent& event);
  std::string name_of(const Agent& agent, std::size_t sensor) const;
  void add_notice(const std::string& text);

  std::unique_ptr<StreamListener> listener_;
  AgentsOptions options_;
  mutable std::mutex mutex_;
  std::map<std::string, Agent> agents_;
  std::vector<std::string> notices_;
  std::string disk_problem_;
  std::uint64_t connections_made_ = 0;
  Clock::time_point drain_began_{};
  std::atomic<bool> begun_{false}, draining_{false}, ended_{false};
  std::list<Connection> connections_;  // of the accepting thread, until that has ended
  std::thread accepting_;              // the last: it uses all of the above
};

}  // namespace trilat
