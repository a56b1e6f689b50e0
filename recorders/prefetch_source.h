// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

#include "recorders/frame_source.h"

namespace trilat {

// Takes events of another source ahead of time, on a thread of its own, so that each is there when it is due.
class PrefetchSource : public FrameSource {
 public:
  PrefetchSource(std::unique_ptr<FrameSource> inner, std::size_t events_ahead);
  ~PrefetchSource() override;
  const SessionHeader& header() const override { return inner_->header(); }
  // What the inner source throws is thrown here, behind the events before it.
  std::optional<SourceEvent> next() override;
  void stop() override;

 private:
  void fetch();

  std::unique_ptr<FrameSource> inner_;
  std::size_t events_ahead_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<SourceEvent> events_;
  std::exception_ptr failure_;
  bool ended_ = false, stopped_ = false;
  std::thread thread_;  // the last: it uses all of the above
};

}  // namespace trilat
