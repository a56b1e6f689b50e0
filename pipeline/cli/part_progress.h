// SPDX-License-Identifier: MIT
#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "pipeline/cli/progress.h"

namespace trilat {

// Progress of work in named parts, one after the other: each gets a bar and a clock of its own. set() may be
// called by any thread.
class PartProgress {
 public:
  void set(const std::string& part, double share) {
    const std::lock_guard lock(mutex_);
    if (!progress_ || part != part_) progress_.emplace(part);
    part_ = part;
    progress_->set(share);
  }

 private:
  std::mutex mutex_;
  std::string part_;
  std::optional<Progress> progress_;
};

}  // namespace trilat
