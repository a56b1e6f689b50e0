// SPDX-License-Identifier: MIT
#include "recorders/capture.h"

#include <algorithm>
#include <chrono>
#include <random>
#include <system_error>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/session/session_writer.h"
#include "datasets/session/write_session.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

std::uint64_t new_log_id() {
  std::random_device device;
  return std::uint64_t{device()} << 32 | device();
}

std::uint64_t free_bytes(const std::filesystem::path& path) {
  std::error_code error;
  const auto space = std::filesystem::space(path.has_parent_path() ? path.parent_path() : ".", error);
  return error ? ~std::uint64_t{0} : space.available;
}

LogHead head_of(const std::vector<std::unique_ptr<FrameSource>>& sources, const std::string& started_utc,
                const std::filesystem::path& path) {
  LogHead head{new_log_id(), steady_now_ns(), {}, joint_header(sources)};
  if (!started_utc.empty()) head.session.started_utc = started_utc;
  check_session_header(head.session, path.string());
  return head;
}

// One recording from the first event to the last.
class Recording {
 public:
  Recording(const std::vector<std::unique_ptr<FrameSource>>& sources, const std::filesystem::path& path,
            const CaptureOptions& options)
      : path_(path),
        options_(options),
        log_(log_name(path), head_of(sources, options.started_utc, path)),
        spool_(sources, log_, options.spool) {}

  CaptureSummary run() {
    constexpr auto kPatience =
        std::chrono::milliseconds(50);  // between looks at the clock and the stop request
    CaptureSummary summary;
    while (!spool_.wait_for_end(kPatience)) {
      if (options_.stop_requested && options_.stop_requested()) stop(CaptureEnd::stop_requested, summary.end);
      if (options_.duration_s > 0.0 && seconds_since(start_) >= options_.duration_s)
        stop(CaptureEnd::duration_over, summary.end);
      if (seconds_since(last_look_) >= options_.look_period_s) look(summary.end);
    }
    spool_.count_silence_to_the_end();
    spool_.look_after();
    show_notices();
    if (const std::string problem = spool_.log_problem(); !problem.empty())
      throw OutputError(log_name(path_).string(), problem);
    log_.finish(spool_.source_problem());
    summary.last = status();
    summary.source_failed = !spool_.source_problem().empty();
    return summary;
  }

 private:
  void look(CaptureEnd& end) {
    spool_.look_after();
    const CaptureStatus now = status();
    last_look_ = Clock::now();
    show_notices();
    if (options_.on_status) options_.on_status(now);
    if (now.disk_free_bytes < options_.reserve_bytes + now.waiting_bytes + now.log_bytes)
      stop(CaptureEnd::disk_full, end);
  }

  void show_notices() {
    for (const std::string& text : spool_.take_notices())
      if (options_.on_notice) options_.on_notice(text);
  }

  // The first reason stands; what waits is still stored.
  void stop(CaptureEnd reason, CaptureEnd& end) {
    if (stopped_) return;
    stopped_ = true;
    end = reason;
    spool_.stop();
  }

  CaptureStatus status() {
    const double period_s = std::max(1e-3, seconds_since(last_look_));
    return {seconds_since(start_), spool_.status(period_s), spool_.waiting_bytes(), log_.written_bytes(),
            free_bytes(path_)};
  }

  const std::filesystem::path& path_;
  const CaptureOptions& options_;
  EventLogWriter log_;
  Clock::time_point start_ = Clock::now(), last_look_ = start_;
  bool stopped_ = false;
  Spool spool_;  // the last: its threads use the log
};

}  // namespace

bool CaptureSummary::lost_frames() const {
  return std::ranges::any_of(last.sensors,
                             [](const SensorStatus& s) { return s.lost_at_source + s.lost_in_queue > 0; });
}

std::filesystem::path log_name(const std::filesystem::path& path) { return path.string() + ".trilog"; }

CaptureSummary capture(const std::vector<std::unique_ptr<FrameSource>>& sources,
                       const std::filesystem::path& path, const CaptureOptions& options) {
  const std::string log = log_name(path).string(),
                    remedy = "`trilat recover " + log + "` makes a session of it";
  CaptureSummary summary;
  try {
    summary = Recording(sources, path, options).run();
  } catch (const OutputError& error) {
    throw OutputError(log, error.problem() + ". It holds all but the last second before that: " + remedy);
  }
  try {
    summary.log_left = close_recording({log}, path, options.on_writing);
  } catch (const OutputError& error) {
    throw OutputError(error.place(),
                      error.problem() + ". The recording is whole in " + log + ": make room, then " + remedy);
  }
  summary.session_bytes = std::filesystem::file_size(path);
  return summary;
}

}  // namespace trilat
