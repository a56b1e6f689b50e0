// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "recorders/network/link/wire.h"

namespace trilat {

// A connection that has not yet said who it is.
struct Stranger {
  std::string from;
  std::atomic<bool> evicted{false};  // it has to make room
};

// Bounds how many strangers there are without locking anybody out: a newcomer always comes in, and where
// there are too many the oldest has to go. Any thread.
class PendingStrangers {
 public:
  // Of one address at most `limit_an_address`, but for this machine's own.
  PendingStrangers(std::size_t limit, std::size_t limit_an_address);

  // Waits a while where too many of the evicted are still about.
  std::shared_ptr<Stranger> add(const std::string& from, std::chrono::milliseconds at_most);
  // It has said who it is, or has gone. Once or more.
  void remove(const std::shared_ptr<Stranger>& stranger);

 private:
  void make_room(const std::string& from);

  std::size_t limit_, limit_an_address_;
  std::mutex mutex_;
  std::condition_variable removed_;
  std::list<std::shared_ptr<Stranger>> strangers_;  // the oldest first
};

// Passes on one line a second; the next one says how many were left out. Any thread.
class RefusalLog {
 public:
  explicit RefusalLog(std::function<void(const std::string&)> write) : write_(std::move(write)) {}

  void add(const std::string& line) {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (written_ && now - last_ < std::chrono::seconds(1)) {
      ++left_out_;
      return;
    }
    write_(left_out_ ? line + " (and " + std::to_string(left_out_) + " more before)" : line);
    last_ = now;
    written_ = true;
    left_out_ = 0;
  }

 private:
  std::mutex mutex_;
  std::function<void(const std::string&)> write_;
  std::chrono::steady_clock::time_point last_;
  bool written_ = false;
  std::size_t left_out_ = 0;
};

// What the recording machine knows of one agent. Who has been admitted as its data connection owns
// next_number, lost and earlier; the rest is the book's.
struct AgentSlot {
  std::string name;
  std::uint64_t incarnation = 0;
  bool simulated = false;
  std::vector<SensorDescription> sensors;
  std::size_t first_sensor = 0;  // in the session; known when the recording has begun
  bool connected = false;
  bool replaced = false;  // a newer connection of the same run of the agent waits for this one to leave
  bool said_bye = false;
  std::string source_problem;           // why the source of this or an earlier run broke
  bool restarted = false;               // another run of the agent than the connection before
  std::uint64_t clock_connections = 0;  // the last one counts
  std::optional<std::chrono::steady_clock::time_point> lost_at;

  std::uint64_t next_number = 0;
  std::optional<std::uint64_t> held_to;  // what the agent held when it was stopped, to this number
  std::vector<DropCount> lost;           // totals of this run of the agent, a sensor each
  std::vector<DropCount> earlier;        // of its earlier runs, and what was damaged on the way
};

// Which agents take part. Any thread.
class AgentBook {
 public:
  // A place for a data connection, or why there is none. `proven_name` is empty where nothing was proved. May
  // wait a while for an older connection of the same run to go.
  std::variant<AgentSlot*, RefusalMessage> admit(const HelloMessage& hello, const std::string& proven_name);
  // The data connection has gone.
  void leave(AgentSlot& slot);
  // `problem`: why its source broke; empty where it ended.
  void say_bye(AgentSlot& slot, const std::string& problem);
  // True when the connection that owns the slot has to go.
  bool must_leave(const AgentSlot& slot);

  // The slot and the number of a new clock connection; nothing when its agent does not take part.
  std::optional<std::pair<AgentSlot*, std::uint64_t>> admit_clock(const HelloMessage& hello,
                                                                  const std::string& proven_name);
  bool clock_wanted(const AgentSlot& slot, std::uint64_t connection);

  // Waits until `count` agents are connected and begins with those: false where it takes too long or `stop`
  // says true. InputError where their sensors make no session.
  bool begin(std::size_t count, std::chrono::milliseconds timeout, const std::function<bool()>& stop);
  bool begun();
  bool all_said_bye();
  // Agents that have not sent all they held: they are away, or have not said bye.
  std::vector<std::string> unfinished();
  std::vector<std::string> names();
  struct BrokenSource {
    std::string agent, problem;
  };
  std::vector<BrokenSource> broken_sources();
  // Of the session, once it has begun.
  std::vector<SensorDescription> sensors();
  bool simulated();

 private:
  std::optional<RefusalMessage> refuse_known(AgentSlot& slot, const HelloMessage& hello,
                                             std::unique_lock<std::mutex>& lock);
  AgentSlot* find(const std::string& name);
  void name_sensors();
  bool recording_over() const;  // everybody has said bye

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::unique_ptr<AgentSlot>> slots_;
  bool begun_ = false;
};

}  // namespace trilat
