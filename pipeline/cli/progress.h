// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>

namespace trilat {

// Shows how far long work is, on stderr: a bar with the time left on a terminal, a line every ten seconds
// elsewhere, nothing for work that is done within a moment. set() may be called by any thread.
class Progress {
 public:
  explicit Progress(std::string label);
  ~Progress();
  void set(double share);

 private:
  void show(double share, double elapsed_s);

  std::string label_;
  bool terminal_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point start_, last_;
  bool drawn_ = false;
};

// Progress of stages one after the other: each gets a bar and a clock of its own. set() may be called by any
// thread.
class StageProgressBars {
 public:
  void set(const std::string& stage, double share) {
    const std::lock_guard lock(mutex_);
    if (!progress_ || stage != stage_) progress_.emplace(stage);
    stage_ = stage;
    progress_->set(share);
  }

 private:
  std::mutex mutex_;
  std::string stage_;
  std::optional<Progress> progress_;
};

}  // namespace trilat
