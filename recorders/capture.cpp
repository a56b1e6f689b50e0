// SPDX-License-Identifier: MIT
#include "recorders/capture.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>

#include <fcntl.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "recorders/capture_queue.h"
#include "recorders/capture_store.h"

namespace trilat {
namespace {

// Asks the system now and then, on a thread of its own, to put what has been written of a file on the disk,
// so that a power cut costs little more than a kill.
class CaptureSync {
 public:
  CaptureSync(const std::filesystem::path& file, std::chrono::milliseconds period);
  ~CaptureSync();
  CaptureSync(const CaptureSync&) = delete;
  CaptureSync& operator=(const CaptureSync&) = delete;

 private:
  int file_;
  std::mutex mutex_;
  std::condition_variable ended_changed_;
  bool ended_ = false;
  std::thread thread_;  // the last: it uses all of the above
};

CaptureSync::CaptureSync(const std::filesystem::path& file, std::chrono::milliseconds period)
    : file_(::open(file.c_str(), O_RDONLY | O_CLOEXEC)), thread_([this, period] {
        std::unique_lock lock(mutex_);
        while (!ended_changed_.wait_for(lock, period, [&] { return ended_; })) {
          lock.unlock();
          if (file_ >= 0) (void)::fdatasync(file_);  // a disk that fails tells the writer, too
          lock.lock();
        }
      }) {}

CaptureSync::~CaptureSync() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  ended_changed_.notify_all();
  thread_.join();
  if (file_ >= 0) ::close(file_);
}

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
  return std::any_of(last.sensors.begin(), last.sensors.end(),
                     [](const SensorStatus& s) { return s.lost_at_source + s.lost_in_queue > 0; });
}

CaptureSummary capture(const std::vector<std::unique_ptr<FrameSource>>& sources,
                       const std::filesystem::path& path, const CaptureOptions& options) {
  return Recording(sources, path, options).run();
}

}  // namespace trilat
