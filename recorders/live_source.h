// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "recorders/frame_source.h"

namespace trilat {

struct LiveOptions {
  double speed = 1.0;           // times real time; 0: as fast as they are taken, nothing is ever dropped
  bool stamp_arrivals = false;  // with the clock of this machine, as a sensor's driver would; speed 1 only
  bool one_clock = false;       // arrivals are on the frames' host clock, not on those of other machines
  std::int64_t origin_ns = 0;   // what the frames' host clock shows at the start
};

// Delivers what another source has as a sensor would: each event at its time, moved to now on the host clock,
// and whether somebody takes it or not.
class LiveSource : public FrameSource {
 public:
  LiveSource(std::unique_ptr<FrameSource> inner, const LiveOptions& options);
  const SessionHeader& header() const override { return inner_->header(); }
  std::optional<SourceEvent> next() override;
  void stop() override;
  bool live() const override { return options_.speed > 0.0; }
  // Starts, if next() has not yet, and tells what the host clock showed then.
  std::int64_t start();

 private:
  // The next event in the order of their times; the inner source's order is frame number by frame number.
  std::optional<std::pair<std::int64_t, SourceEvent>> earliest();
  // Since the start, by the clock that stamped the event.
  std::int64_t due_ns(const SourceEvent& event);
  bool wait_until(std::int64_t host_ns);
  // True when the event comes so late that its stamp would not be a sensor's; then it is lost.
  bool too_late(const SourceEvent& event, std::int64_t due_host_ns) const;
  SourceEvent lost(const SourceEvent& event);
  void look_ahead();
  void move_to_now(SourceEvent& event) const;

  std::unique_ptr<FrameSource> inner_;
  LiveOptions options_;
  std::optional<std::int64_t> start_ns_;
  std::multimap<std::int64_t, SourceEvent> ahead_;             // by due time
  std::vector<std::optional<std::int64_t>> first_arrival_ns_;  // one a sensor
  std::vector<std::int64_t> lost_, last_lost_;                 // one a sensor; frames, by their numbers
  std::mutex mutex_;
  std::condition_variable stop_changed_;
  bool stopped_ = false;
};

}  // namespace trilat
