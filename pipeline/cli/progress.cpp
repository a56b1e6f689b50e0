// SPDX-License-Identifier: MIT
#include "pipeline/cli/progress.h"

#include <algorithm>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace trilat {
namespace {

double seconds_between(std::chrono::steady_clock::time_point a, std::chrono::steady_clock::time_point b) {
  return std::chrono::duration<double>(b - a).count();
}

}  // namespace

Progress::Progress(std::string label)
    : label_(std::move(label)),
      terminal_(::isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()),
      last_(start_) {}

Progress::~Progress() {
  if (drawn_ && terminal_) std::fputs("\r\033[K", stderr);
}

void Progress::set(double share) {
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (seconds_between(last_, now) < (terminal_ ? 0.2 : 10.0)) return;
  last_ = now;
  show(std::clamp(share, 0.0, 1.0), seconds_between(start_, now));
}

void Progress::show(double share, double elapsed_s) {
  const std::string left =
      share > 0.01 ? fmt::format("{:.0f} s left", elapsed_s * (1.0 - share) / share) : "…";
  if (terminal_) {
    constexpr int kWidth = 30;
    const int full = static_cast<int>(share * kWidth);
    std::fputs(fmt::format("\r\033[K{} [{}{}] {:3.0f} %  {}", label_,
                           std::string(static_cast<std::size_t>(full), '#'),
                           std::string(static_cast<std::size_t>(kWidth - full), '.'), 100.0 * share, left)
                   .c_str(),
               stderr);
    std::fflush(stderr);
  } else {
    std::fputs(fmt::format("{}: {:.0f} %, {}\n", label_, 100.0 * share, left).c_str(), stderr);
  }
  drawn_ = true;
}

}  // namespace trilat
