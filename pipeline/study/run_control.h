// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <functional>
#include <utility>

#include "datasets/base/error.h"

namespace trilat {

// Stop request and progress of a long computation.
struct RunControl {
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};  // the share that is done; from any thread

  bool stopped() const { return stop_requested && stop_requested(); }
  void check() const {
    if (stopped()) throw Interrupted();
  }
  void report(double share) const {
    if (progress) progress(share);
  }
};

// Wall clock since it was made.
class RunningTime {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Progress of the whole from that of a stage that is `share` of the whole and begins when `before` of it is
// done.
inline std::function<void(double)> share_of(std::function<void(double)> progress, double before,
                                            double share) {
  if (!progress) return {};
  return [progress = std::move(progress), before, share](double done) { progress(before + share * done); };
}

}  // namespace trilat
