// SPDX-License-Identifier: MIT
#include "pipeline/cli/terminal/live_display.h"

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <unistd.h>

namespace trilat {

// Outlives the display when its thread is stuck in a terminal.
struct LiveDisplay::Shared {
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<std::string> texts;
  std::string picture, line;
  bool line_changed = false, ended = false, done = false;
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  double next_s = 0.0;

  bool something() const { return !texts.empty() || line_changed || ended; }

  void run() {
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [&] { return something(); });
      std::string out;
      if (terminal) out += "\r\033[K";
      for (const std::string& text : texts) out += text + "\n";
      texts.clear();
      if (line_changed && !ended) out += picture + line + (terminal ? "" : "\n");
      line_changed = false;
      const bool last = ended;
      lock.unlock();
      std::fputs(out.c_str(), stderr);  // nobody to tell when this fails
      std::fflush(stderr);
      lock.lock();
      if (last) break;
    }
    done = true;
    changed.notify_all();
  }
};

LiveDisplay::LiveDisplay() : shared_(std::make_shared<Shared>()) {
  std::thread([shared = shared_] { shared->run(); }).detach();
}

LiveDisplay::~LiveDisplay() {
  std::unique_lock lock(shared_->mutex);
  shared_->ended = true;
  shared_->changed.notify_all();
  shared_->changed.wait_for(lock, std::chrono::seconds(1), [&] { return shared_->done; });
}

void LiveDisplay::show(const CaptureStatus& status, std::string picture) {
  constexpr double kLinePeriod_s = 10.0;  // where lines stay
  const std::lock_guard lock(shared_->mutex);
  if (!shared_->terminal && status.elapsed_s < shared_->next_s) return;
  shared_->next_s = status.elapsed_s + kLinePeriod_s;
  shared_->picture = std::move(picture);
  shared_->line = status_line(status);
  shared_->line_changed = true;
  shared_->changed.notify_all();
}

void LiveDisplay::say(const std::string& text) {
  constexpr std::size_t kMostTexts = 200;  // while the terminal takes nothing
  const std::lock_guard lock(shared_->mutex);
  if (shared_->texts.size() < kMostTexts) shared_->texts.push_back(text);
  shared_->changed.notify_all();
}

std::string status_line(const CaptureStatus& status) {
  const double written =
      status.elapsed_s > 0.0 ? static_cast<double>(status.file_bytes) / status.elapsed_s : 0.0;
  std::string line = fmt::format("{:4.0f} s ", status.elapsed_s);
  std::int64_t lost = 0;
  for (const SensorStatus& s : status.sensors) {
    line += fmt::format(" {} {:.1f} Hz", s.name, s.rate_hz);
    lost += s.lost_at_source + s.lost_in_queue;
  }
  line += fmt::format(
      "  lost {}  queue {:.0f} %  {:.1f} MB/s  {:.1f} GB free", lost,
      100.0 * static_cast<double>(status.queue_bytes) / static_cast<double>(status.queue_limit_bytes),
      1e-6 * written, 1e-9 * static_cast<double>(status.disk_free_bytes));
  if (written > 0.0)
    line += fmt::format(" ({:.0f} min)", static_cast<double>(status.disk_free_bytes) / written / 60.0);
  return line;
}

}  // namespace trilat
