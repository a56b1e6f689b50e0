// SPDX-License-Identifier: MIT
#include "recorders/prefetch_source.h"

#include <utility>

namespace trilat {

PrefetchSource::PrefetchSource(std::unique_ptr<FrameSource> inner, std::size_t events_ahead)
    : inner_(std::move(inner)), events_ahead_(events_ahead), thread_([this] { fetch(); }) {}

PrefetchSource::~PrefetchSource() {
  stop();
  thread_.join();
}

void PrefetchSource::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  inner_->stop();
  changed_.notify_all();
}

void PrefetchSource::fetch() {
  std::exception_ptr failure;
  try {
    while (auto event = inner_->next()) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stopped_ || events_.size() < events_ahead_; });
      if (stopped_) break;
      events_.push_back(std::move(*event));
      changed_.notify_all();
    }
  } catch (...) {
    failure = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  failure_ = failure;
  ended_ = true;
  changed_.notify_all();
}

std::optional<SourceEvent> PrefetchSource::next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return stopped_ || ended_ || !events_.empty(); });
  if (stopped_) return std::nullopt;
  if (events_.empty()) {
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    return std::nullopt;
  }
  SourceEvent event = std::move(events_.front());
  events_.pop_front();
  changed_.notify_all();
  return event;
}

}  // namespace trilat
