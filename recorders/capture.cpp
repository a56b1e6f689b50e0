// SPDX-License-Identifier: MIT
#include "recorders/capture.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/session/session_writer.h"
#include "recorders/capture_queue.h"
#include "recorders/frame_source.h"

namespace trilat {
namespace {

// One stream of a sensor: when its last frame came, and which numbers are missing.
struct StreamWatch {
  using Clock = std::chrono::steady_clock;
  const char* name;
  bool expected;  // the sensor has such a stream
  Clock::time_point heard = Clock::now();
  bool silent = false;
  std::optional<std::int64_t> last_sequence = std::nullopt;
  std::int64_t missing = 0;  // by gaps in the sequence numbers
  std::uint64_t frames = 0, at_last_status = 0;

  void add(const FrameStamp& stamp) {
    // A source that begins anew, or numbers by another clock, has lost nothing by that.
    constexpr std::int64_t kLargestGap = 1'000'000;
    const std::int64_t gap = last_sequence ? stamp.sequence - *last_sequence - 1 : 0;
    if (gap > 0 && gap < kLargestGap) missing += gap;
    last_sequence = stamp.sequence;
    heard = Clock::now();
    ++frames;
  }
};

// The writing side of a recording: stores events and knows how each sensor is. One thread.
class CaptureStore {
 public:
  using Clock = StreamWatch::Clock;
  CaptureStore(SessionWriter& writer, const SessionHeader& header, const CaptureOptions& options)
      : writer_(writer), options_(options) {
    for (const SensorDescription& sensor : header.sensors) {
      status_.push_back({.name = sensor.name});
      sensors_.push_back({.bodies = {"bodies", true}, .depth = {"depth", sensor.has_depth}});
    }
  }

  void add(const SourceEvent& event) {
    const std::size_t s = event.sensor;
    SensorStatus& status = status_.at(s);
    Sensor& sensor = sensors_.at(s);
    if (const auto* frame = std::get_if<BodyFrame>(&event.data)) {
      heard(s, sensor.bodies, frame->stamp);
      writer_.add_body_frame(s, *frame);
      ++status.body_frames;
      if (options_.on_bodies) options_.on_bodies(status.name, *frame);
    } else if (const auto* depth = std::get_if<EncodedDepthFrame>(&event.data)) {
      heard(s, sensor.depth, depth->stamp);
      writer_.add_depth_frame(s, *depth);
      ++status.depth_frames;
    } else if (const auto* exchange = std::get_if<ClockExchange>(&event.data)) {
      writer_.add_clock_exchange(s, *exchange);
    } else if (const auto* count = std::get_if<DropCount>(&event.data)) {
      sensor.counted_at_source = count->at_source;
      sensor.lost_on_the_way = count->in_queue;
    } else if (const auto* text = std::get_if<SourceNotice>(&event.data)) {
      notice(s, text->text);
    } else {
      TRILAT_CHECK(false, "depth leaves the queue compressed");
    }
  }

  void notice(std::size_t sensor, const std::string& text) {
    writer_.add_notice(sensor, {steady_now_ns(), text});
    if (options_.on_notice) options_.on_notice(status_.at(sensor).name, text);
  }

  // Names sensors that have sent no frame for too long, and streams of theirs.
  void look_for_silence(Clock::time_point now) {
    const std::chrono::duration<double> limit(options_.silence_s);
    for (std::size_t s = 0; s < status_.size(); ++s) {
      Sensor& sensor = sensors_[s];
      for (StreamWatch* stream : {&sensor.bodies, &sensor.depth}) {
        if (!stream->expected || stream->silent || !(now - stream->heard > limit)) continue;
        stream->silent = true;
        notice(s, fmt::format("no frame of {} for {:.1f} s", stream->name, options_.silence_s));
      }
    }
  }

  // Stores how many frames were lost, where that has changed: those that the source counts or that are
  // missing by their numbers, and those for which a queue had no room, which leave gaps, too.
  void note_drops(const CaptureQueue& queue) {
    for (std::size_t s = 0; s < status_.size(); ++s) {
      const Sensor& sensor = sensors_[s];
      const std::int64_t in_queue = queue.dropped(s) + sensor.lost_on_the_way;
      const std::int64_t missing = sensor.bodies.missing + sensor.depth.missing;
      const std::int64_t at_source = std::max(sensor.counted_at_source, missing - in_queue);
      if (at_source == status_[s].lost_at_source && in_queue == status_[s].lost_in_queue) continue;
      status_[s].lost_at_source = at_source;
      status_[s].lost_in_queue = in_queue;
      writer_.add_drop_count(s, {steady_now_ns(), at_source, in_queue});
    }
  }

  // `period_s`: since it was last asked.
  std::vector<SensorStatus> status(double period_s) {
    for (std::size_t s = 0; s < status_.size(); ++s) {
      std::optional<double> slowest_hz;
      for (StreamWatch* stream : {&sensors_[s].bodies, &sensors_[s].depth}) {
        const double rate_hz = static_cast<double>(stream->frames - stream->at_last_status) / period_s;
        stream->at_last_status = stream->frames;
        if (stream->expected) slowest_hz = std::min(rate_hz, slowest_hz.value_or(rate_hz));
      }
      status_[s].rate_hz = slowest_hz.value_or(0.0);
    }
    return status_;
  }

 private:
  struct Sensor {
    StreamWatch bodies, depth;
    std::int64_t counted_at_source = 0;
    std::int64_t lost_on_the_way = 0;  // in an agent's queue
  };

  void heard(std::size_t sensor, StreamWatch& stream, const FrameStamp& stamp) {
    stream.add(stamp);
    if (!std::exchange(stream.silent, false)) return;
    notice(sensor, fmt::format("frames of {} again", stream.name));
  }

  SessionWriter& writer_;
  const CaptureOptions& options_;
  std::vector<SensorStatus> status_;
  std::vector<Sensor> sensors_;
};

// Asks the system now and then, on a thread of its own, to put what has been written of a file on the disk,
// so that a power cut costs little more than a kill.
class CaptureSync {
 public:
  CaptureSync(const std::filesystem::path& file, std::chrono::milliseconds period)
      : file_(::open(file.c_str(), O_RDONLY | O_CLOEXEC)), thread_([this, period] {
          std::unique_lock lock(mutex_);
          while (!ended_changed_.wait_for(lock, period, [&] { return ended_; })) {
            lock.unlock();
            if (file_ >= 0) (void)::fdatasync(file_);  // a disk that fails tells the writer, too
            lock.lock();
          }
        }) {}

  ~CaptureSync() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    ended_changed_.notify_all();
    thread_.join();
    if (file_ >= 0) ::close(file_);
  }

  CaptureSync(const CaptureSync&) = delete;
  CaptureSync& operator=(const CaptureSync&) = delete;

 private:
  int file_;
  std::mutex mutex_;
  std::condition_variable ended_changed_;
  bool ended_ = false;
  std::thread thread_;  // the last: it uses all of the above
};

using Clock = std::chrono::steady_clock;

constexpr auto kPatience = std::chrono::milliseconds(50);  // between looks at the clock and the stop request

Clock::duration from_seconds(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

// The sensors of all sources one behind the other.
SessionHeader joint_header(const std::vector<std::unique_ptr<FrameSource>>& sources,
                           const std::string& started_utc) {
  SessionHeader header = sources.at(0)->header();
  if (!started_utc.empty()) header.started_utc = started_utc;
  for (std::size_t i = 1; i < sources.size(); ++i) {
    const SessionHeader& more = sources[i]->header();
    header.simulated = header.simulated || more.simulated;
    if (more.note != header.note) header.note += (header.note.empty() ? "" : "; ") + more.note;
    header.sensors.insert(header.sensors.end(), more.sensors.begin(), more.sensors.end());
  }
  return header;
}

// Nothing when the system does not say.
std::optional<std::uint64_t> free_bytes(const std::filesystem::path& path) {
  std::error_code error;
  const auto space = std::filesystem::space(path.has_parent_path() ? path.parent_path() : ".", error);
  return error ? std::nullopt : std::optional<std::uint64_t>(space.available);
}

// One recording from the first event to the last.
class Recording {
 public:
  Recording(const std::vector<std::unique_ptr<FrameSource>>& sources, const std::filesystem::path& path,
            const CaptureOptions& options)
      : path_(path),
        options_(options),
        header_(joint_header(sources, options.started_utc)),
        writer_(path, header_, options.depth_compression),
        queue_(header_.sensors.size(), options.queue_bytes),
        store_(writer_, header_, options),
        sync_(partial_name(path),
              std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * options.sync_period_s))),
        intake_(sources, queue_, options.depth_compression, options.workers) {}

  CaptureSummary run() {
    CaptureSummary summary;
    summary.end = CaptureEnd::source_ended;
    try {
      while (!queue_.drained()) {
        const Clock::time_point now = Clock::now();
        if (const auto event = queue_.pop(now + kPatience)) store_.add(*event);
        keep_house(now, summary.end);
      }
      store_.note_drops(queue_);
      writer_.finish();
    } catch (const OutputError& error) {
      summary.end = CaptureEnd::disk_failed;
      summary.problem = error.what();
    }
    summary.last = status(Clock::now());
    summary.source_failed = intake_.source_failed();
    return summary;
  }

 private:
  void keep_house(Clock::time_point now, CaptureEnd& end) {
    if (now - last_flush_ >= from_seconds(options_.flush_period_s)) flush(now, end);
    if (options_.stop_requested && options_.stop_requested()) stop(CaptureEnd::stop_requested, end);
    if (options_.duration_s > 0.0 && now - start_ >= from_seconds(options_.duration_s))
      stop(CaptureEnd::duration_over, end);
  }

  void flush(Clock::time_point now, CaptureEnd& end) {
    store_.look_for_silence(now);
    store_.note_drops(queue_);
    writer_.flush();
    last_flush_ = now;
    const CaptureStatus safe = status(now);
    if (options_.on_status) options_.on_status(safe);
    if (const auto left = free_bytes(path_); left && *left < options_.reserve_bytes + safe.queue_bytes)
      stop(CaptureEnd::disk_full, end);
  }

  // The first reason stands; what is in the queue is still stored.
  void stop(CaptureEnd reason, CaptureEnd& end) {
    if (stopped_) return;
    stopped_ = true;
    end = reason;
    intake_.stop();
  }

  CaptureStatus status(Clock::time_point now) {
    const auto seconds = [](Clock::duration d) { return std::chrono::duration<double>(d).count(); };
    CaptureStatus status;
    status.elapsed_s = seconds(now - start_);
    status.sensors = store_.status(std::max(1e-3, seconds(now - last_status_)));
    last_status_ = now;
    status.queue_bytes = queue_.bytes();
    status.queue_limit_bytes = options_.queue_bytes;
    std::error_code ignored;
    status.file_bytes =
        std::filesystem::file_size(std::filesystem::exists(path_) ? path_ : partial_name(path_), ignored);
    status.disk_free_bytes = free_bytes(path_).value_or(0);
    return status;
  }

  std::filesystem::path path_;
  const CaptureOptions& options_;
  SessionHeader header_;
  SessionWriter writer_;
  CaptureQueue queue_;
  CaptureStore store_;
  CaptureSync sync_;
  Clock::time_point start_ = Clock::now(), last_flush_ = start_, last_status_ = start_;
  bool stopped_ = false;
  CaptureIntake intake_;  // the last: its threads use all of the above
};

}  // namespace

bool CaptureSummary::lost_frames() const {
  return std::ranges::any_of(last.sensors,
                             [](const SensorStatus& s) { return s.lost_at_source + s.lost_in_queue > 0; });
}

CaptureSummary capture(const std::vector<std::unique_ptr<FrameSource>>& sources,
                       const std::filesystem::path& path, const CaptureOptions& options) {
  return Recording(sources, path, options).run();
}

}  // namespace trilat
