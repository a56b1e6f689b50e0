// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

namespace trilat {

// Asks the system now and then, on a thread of its own, to put what has been written of a file on the disk,
// so that a power cut costs little more than a kill.
class CaptureSync {
 public:
  CaptureSync(const std::filesystem::path& file, std::chrono::milliseconds period);
  ~CaptureSync();
  CaptureSync(const CaptureSync&) = delete;
  CaptureSync& operator=(const CaptureSync&) = delete;

 private:
  int file_;
  std::mutex mutex_;
  std::condition_variable ended_changed_;
  bool ended_ = false;
  std::thread thread_;  // the last: it uses all of the above
};

}  // namespace trilat
