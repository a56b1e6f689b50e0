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
#include <string>

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

}  // namespace trilat
