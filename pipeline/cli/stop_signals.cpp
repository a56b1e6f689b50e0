// SPDX-License-Identifier: MIT
#include <atomic>
#include <csignal>

#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

std::atomic<int> stop_signals{0};

// The first signal asks for an orderly end; the second takes the default way out.
void on_signal(int number) {
  if (stop_signals.fetch_add(1) > 0) {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
}

}  // namespace

bool stop_requested() { return stop_signals.load(std::memory_order_relaxed) > 0; }

void end_in_order() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

}  // namespace trilat
