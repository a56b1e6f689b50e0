// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "datasets/synthetic/simulation_spec.h"
#include "datasets/synthetic/wand_motion.h"
#include "recorders/frame_source.h"
#include "recorders/synthetic_source.h"

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
  // Starts the source, unless next() has done so. The host clock's time at that start, in nanoseconds.
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

// Virtual Kinects watching a generated person walk, or hold a wand at many places, as one asks for them by
// text.
struct SyntheticRequest {
  std::size_t sensors = 4;
  std::uint64_t seed = 1;
  enum class Depth { none, walker, wand } depth = Depth::walker;  // what the depth frames show
  double duration_s = 86400.0;
  LiveOptions live;
};

// Scene and sensors of a synthetic source; the same for equal requests.
struct SyntheticSetup {
  SimulationSpec simulation;
  SimulatedItem item;
  Motion motion;
  std::optional<WandMotion> wand = {};  // that the person holds
  std::vector<SimulatedSensor> sensors;
};
SyntheticSetup setup_of(const SyntheticRequest& request);

// The request in a text "synthetic:…"; nothing when the text asks for another kind of source. InputError as
// in open_source().
std::optional<SyntheticRequest> synthetic_request(const std::string& text);

// On an agent all arrivals are stamped with this machine's clock, which the recording machine compares with
// its own; that needs real speed.
enum class SourceUse { record, agent };

// A source by its text, KIND:WHAT with settings KEY=VALUE behind commas:
//   synthetic:N          N virtual Kinects and a walking person; seed=1, depth=yes, duration=SECONDS,
//                        speed=FACTOR (1; max: as fast as it can be taken)
// `place` is what an InputError names.
std::unique_ptr<FrameSource> open_source(const std::string& text, const std::string& place = "--source",
                                         SourceUse use = SourceUse::record);

// The texts that open_source() takes, for people.
std::string source_help();

// Takes events of another source ahead of time, on a thread of its own, so that each is there when it is due:
// rendered when they are due, one frame in a hundred of four virtual Kinects came 80 ms late, so 5 ms.
class PrefetchSource : public FrameSource {
 public:
  PrefetchSource(std::unique_ptr<FrameSource> inner, std::size_t events_ahead);
  ~PrefetchSource() override;
  const SessionHeader& header() const override { return inner_->header(); }
  // Throws what the inner source throws, behind the events before it.
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
