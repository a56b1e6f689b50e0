// SPDX-License-Identifier: MIT
#include "pipeline/cli/verbs.h"

#include <atomic>
#include <csignal>

#include "datasets/base/error.h"

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

void add_json(CLI::App& verb, bool& json) {
  verb.add_flag("--json", json, "one JSON document on stdout, and nothing else there");
}

void add_force(CLI::App& verb, bool& force) {
  verb.add_flag("--force", force,
                "replace what stands under the output's name, whoever wrote it; never an input");
}

void add_threads(CLI::App& verb, int& threads) {
  verb.add_option("--threads", threads, "how many threads; 0: one a processor")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
}

}  // namespace trilat
