// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <string>

namespace trilat {

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
