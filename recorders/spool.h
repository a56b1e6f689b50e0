// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "datasets/session/event_log.h"
#include "recorders/frame_source.h"

namespace trilat {

// State of one sensor of a running recording.
struct SensorStatus {
  std::string name;
  std::uint64_t body_frames = 0, depth_frames = 0;     // in the log
  std::int64_t lost_at_source = 0, lost_in_queue = 0;  // the latter also torn ones and impossible times
  double rate_hz = 0.0;  // frames a second since the last status, of the slower of its streams
  std::optional<BodyFrame> newest_bodies = {};  // since the last status
  DepthIntrinsics intrinsics = {};
};

struct SpoolOptions {
  std::size_t limit_bytes = std::size_t{256}
                            << 20;  // of what waits for the log: five seconds of four Kinects
  double silence_s = 1.5;           // without frames for so long, a stream of a sensor is reported as silent
};

// The sensors of all sources one behind the other.
SessionHeader joint_header(const std::vector<std::unique_ptr<FrameSource>>& sources);

// Carries the events of all sources into a log: a thread takes from each source, and one for each sensor
// compresses its depth and appends, so that a sensor's events keep their order. Live sources never wait: what
// finds no room is dropped and counted. A source that breaks is a notice, and the others go on.
class Spool {
 public:
  Spool(const std::vector<std::unique_ptr<FrameSource>>& sources, std::shared_ptr<EventLogWriter> log,
        SpoolOptions options = {});
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  // Asks the sources to end.
  void stop();
  // From now on events go into another log; the one before is no longer used when this returns.
  void go_on_in(std::shared_ptr<EventLogWriter> log);
  // While the disk is full, frames are dropped and counted.
  void set_disk_full(bool full);
  // Any thread.
  void add_exchange(const ClockExchange& exchange);
  // Waits a moment at most; true once all that came is in the log, or the log failed.
  bool wait_for_end(std::chrono::milliseconds patience);
  // Reports and stores which streams are silent and what was lost; a few times a second.
  void look_after();
  // Counts what a stream that is silent would have delivered since its last frame as lost; once, behind the
  // end.
  void count_silence_to_the_end();
  // `period_s`: since it was last asked.
  std::vector<SensorStatus> status(double period_s);
  // Notices since the last call, each with its sensor's name in front.
  std::vector<std::string> take_notices();
  std::size_t waiting_bytes() const;
  std::uint64_t frames() const;        // in the log or logs
  std::string source_problem() const;  // of the first source that broke before it ended; else empty
  std::string log_problem() const;     // what the disk said; else empty

 private:
  using Clock = std::chrono::steady_clock;
  // One stream of a sensor: when its last frame came, and which numbers are missing.
  struct Stream {
    const char* name;
    bool expected = false;  // the sensor has such a stream
    Clock::time_point heard = Clock::now();
    bool silent = false;
    std::optional<std::int64_t> last_sequence{};
    std::int64_t missing = 0;
    std::uint64_t arrived = 0, at_last_status = 0, stored = 0;
    void add(const FrameStamp& stamp);
  };
  struct Sensor {
    SensorDescription description;
    bool is_live = false, has_ended = false;
    Stream bodies, depth;
    std::deque<SourceEvent> waiting{};
    std::int64_t dropped = 0, counted_at_source = 0;
    DropCount stored_drops{};
    std::optional<BodyFrame> newest_bodies{};
  };

  void carry(FrameSource& source, std::size_t first_sensor);
  bool arrived(Sensor& sensor, const SourceEvent& event, std::vector<std::string>& notices);
  void push(SourceEvent event, bool may_wait);
  void work(std::size_t sensor);
  void store(std::size_t sensor, SourceEvent event);
  void notice(std::size_t sensor, const std::string& text);
  void fail(const std::string& problem);
  void append(std::size_t sensor, const LogEvent& event);

  const std::vector<std::unique_ptr<FrameSource>>& sources_;
  // Under the mutex. Who appends holds the outer pointer meanwhile.
  using HeldLog = std::shared_ptr<const std::shared_ptr<EventLogWriter>>;
  HeldLog log_;
  SpoolOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Sensor> sensors_;
  std::size_t waiting_bytes_ = 0, running_sources_, working_;
  bool disk_full_ = false;
  std::string source_problem_, log_problem_;
  std::vector<std::string> notices_;
  std::vector<std::thread> threads_;  // the last: they use all of the above
};

}  // namespace trilat
