// SPDX-License-Identifier: MIT
#include "recorders/capture.h"

#include <algorithm>
#include <chrono>
#include <system_error>
#include <thread>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/session/session_writer.h"
#include "datasets/session/write_session.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

std::uint64_t free_bytes(const std::filesystem::path& path) {
  std::error_code error;
  const auto space = std::filesystem::space(path.has_parent_path() ? path.parent_path() : ".", error);
  return error ? ~std::uint64_t{0} : space.available;
}

LogHead head_of(const std::vector<std::unique_ptr<FrameSource>>& sources, const CaptureOptions& options,
                const std::filesystem::path& path) {
  SessionHeader header = sources.empty() ? SessionHeader{} : joint_header(sources);
  if (!options.started_utc.empty()) header.started_utc = options.started_utc;
  if (options.agents == 0) check_session_header(header, path.string());
  LogHead head = new_log_head(header);
  head.recording = head.id;
  return head;
}

// The own log of a recording, and of which one.
struct OwnLog {
  std::filesystem::path path;
  LogHead head;
};

OwnLog own_log(const std::filesystem::path& path, LogHead head, const CaptureOptions& options) {
  const std::vector<std::filesystem::path> there = logs_beside(path);
  if (there.empty()) return {log_name(path), std::move(head)};
  const std::string first = there.front().string();
  for (const std::filesystem::path& log : there)
    if (is_being_written(log))
      throw InputError(log.string(), "is being written by another recorder; take another name");
  if (options.agents == 0)
    throw InputError(
        first, "exists, of a recorder that was killed: `trilat recover " + first + "`, or take another name");
  const LogHead before = head_of_event_log(there.front());
  if (!share_a_boot(head, before))
    throw InputError(
        first, "was begun before this machine was started anew, which set its clock back: `trilat recover " +
                   path.string() + "`, and take another name");
  head.recording = before.recording;
  return {fmt::format("{}.{}.trilog", path.string(), there.size() + 1), std::move(head)};
}

// One recording from the first event to the last.
class Recording {
 public:
  Recording(const std::vector<std::unique_ptr<FrameSource>>& sources, const std::filesystem::path& path,
            const CaptureOptions& options)
      : sources_(sources),
        path_(path),
        options_(options),
        own_(own_log(path, head_of(sources, options, path), options)),
        log_(std::make_shared<EventLogWriter>(own_.path, own_.head)) {}

  CaptureSummary run(std::vector<LogInput>& logs) {
    if (options_.agents > 0) wait_for_agents();
    if (!sources_.empty()) spool_.emplace(sources_, log_, options_.spool);
    CaptureSummary summary;
    record(summary.end);
    if (spool_) spool_->count_silence_to_the_end();
    if (agents_) agents_->drain();
    look_after();
    check_disk();
    summary.source_failed = spool_ && !spool_->source_problem().empty();
    log_->finish(spool_ ? spool_->source_problem() : "");
    summary.last = status();
    logs = all_logs();
    return summary;
  }

 private:
  void wait_for_agents() {
    AgentsOptions wanted;
    wanted.count = options_.agents;
    wanted.session = path_;
    wanted.recording = own_.head.recording;
    wanted.silence_s = options_.spool.silence_s;
    agents_.emplace(options_.listen(), wanted);
    while (!agents_->all_there()) {
      const bool stopped = options_.stop_requested && options_.stop_requested();
      if (!stopped && seconds_since(start_) < options_.wait_s) {
        std::this_thread::sleep_for(kPollPeriod);
        show_notices();
        continue;
      }
      std::string came;
      for (const std::string& name : agents_->names()) came += (came.empty() ? "" : ", ") + name;
      show_notices();
      log_.reset();
      std::filesystem::remove(own_.path);
      if (stopped) throw Interrupted();
      throw InputError("--agents",
                       fmt::format("{} agents were awaited for {:.0f} s, came: {}; wait longer with --wait-s",
                                   options_.agents, options_.wait_s, came.empty() ? "none" : came));
    }
    log_->begin();
    agents_->begin();
    start_ = last_look_ = Clock::now();
  }

  void record(CaptureEnd& end) {
    while (!is_over()) {
      if (options_.stop_requested && options_.stop_requested()) stop(CaptureEnd::stop_requested, end);
      if (options_.duration_s > 0.0 && seconds_since(start_) >= options_.duration_s)
        stop(CaptureEnd::duration_over, end);
      if (seconds_since(last_look_) >= options_.look_period_s) look(end);
      if (stopped_ && !spool_) break;
    }
  }

  bool is_over() {
    const bool own_is_over = !spool_ || spool_->wait_for_end(kPollPeriod);
    if (!spool_) std::this_thread::sleep_for(kPollPeriod);
    return own_is_over && (!agents_ || stopped_ || agents_->all_done());
  }

  void look(CaptureEnd& end) {
    look_after();
    check_disk();
    const CaptureStatus now = status();
    last_look_ = Clock::now();
    if (options_.on_status) options_.on_status(now);
    if (now.disk_free_bytes < options_.reserve_bytes + now.waiting_bytes + now.log_bytes)
      stop(CaptureEnd::disk_full, end);
  }

  void look_after() {
    if (spool_) spool_->look_after();
    if (agents_) agents_->look_after();
    show_notices();
  }

  void show_notices() {
    const auto show = [&](const std::vector<std::string>& texts) {
      for (const std::string& text : texts)
        if (options_.on_notice) options_.on_notice(text);
    };
    if (spool_) show(spool_->take_notices());
    if (agents_) show(agents_->take_notices());
  }

  void check_disk() {
    if (spool_)
      if (const std::string problem = spool_->log_problem(); !problem.empty())
        throw OutputError(own_.path.string(), problem);
    if (agents_)
      if (const std::string problem = agents_->disk_problem(); !problem.empty())
        throw OutputError(own_.path.string(), problem);
  }

  // The first reason stands; what waits is still stored.
  void stop(CaptureEnd reason, CaptureEnd& end) {
    if (stopped_) return;
    stopped_ = true;
    end = reason;
    if (spool_) spool_->stop();
  }

  CaptureStatus status() {
    const double period_s = std::max(1e-3, seconds_since(last_look_));
    CaptureStatus now{seconds_since(start_), {}, 0, 0, free_bytes(path_)};
    if (spool_) {
      now.sensors = spool_->status(period_s);
      now.waiting_bytes = spool_->waiting_bytes();
    }
    if (agents_)
      for (SensorStatus& sensor : agents_->status(period_s)) now.sensors.push_back(std::move(sensor));
    now.log_bytes = log_->written_bytes();
    std::error_code ignored;
    for (const std::filesystem::path& log : logs_beside(path_))
      if (const auto bytes = std::filesystem::file_size(log, ignored); !ignored && log != own_.path)
        now.log_bytes += bytes;
    return now;
  }

  // Logs of this recording, and of recorders before it that were killed.
  std::vector<LogInput> all_logs() const {
    std::vector<LogInput> logs;
    const std::vector<LogInput> received = agents_ ? agents_->logs() : std::vector<LogInput>{};
    for (const std::filesystem::path& path : logs_beside(path_)) {
      const auto found = std::ranges::find(received, path, &LogInput::path);
      logs.push_back(found != received.end() ? *found : LogInput{path});
    }
    return logs;
  }

  const std::vector<std::unique_ptr<FrameSource>>& sources_;
  const std::filesystem::path& path_;
  const CaptureOptions& options_;
  OwnLog own_;
  std::shared_ptr<EventLogWriter> log_;
  Clock::time_point start_ = Clock::now(), last_look_ = start_;
  bool stopped_ = false;
  std::optional<Agents> agents_;
  std::optional<Spool> spool_;  // the last: its threads use the log
};

}  // namespace

bool CaptureSummary::lost_frames() const {
  return std::ranges::any_of(last.sensors,
                             [](const SensorStatus& s) { return s.lost_at_source + s.lost_in_queue > 0; });
}

std::filesystem::path log_name(const std::filesystem::path& path) { return path.string() + ".trilog"; }

std::filesystem::path found_session(const std::filesystem::path& path) {
  if (std::filesystem::exists(path)) return path;
  for (const std::filesystem::path& other : {log_name(path), partial_name(path)})
    if (std::filesystem::exists(other)) return other;
  return path;
}

std::vector<std::filesystem::path> logs_beside(const std::filesystem::path& path) {
  std::vector<std::filesystem::path> logs;
  const std::string begin = path.filename().string() + ".";
  std::error_code error;
  for (const auto& entry :
       std::filesystem::directory_iterator(path.has_parent_path() ? path.parent_path() : ".", error))
    if (const std::string name = entry.path().filename().string();
        name.starts_with(begin) && name.ends_with(".trilog"))
      logs.push_back(path.parent_path() / name);
  std::ranges::sort(logs, {}, [&](const auto& log) { return std::pair(log != log_name(path), log); });
  return logs;
}

CaptureSummary capture(const std::vector<std::unique_ptr<FrameSource>>& sources,
                       const std::filesystem::path& path, const CaptureOptions& options) {
  const std::string remedy = "`trilat recover " + path.string() + "` makes a session of it";
  CaptureSummary summary;
  std::vector<LogInput> logs;
  try {
    summary = Recording(sources, path, options).run(logs);
  } catch (const OutputError& error) {
    throw OutputError(log_name(path).string(),
                      error.problem() + ". It holds all but the last second before that: " + remedy);
  }
  try {
    const LogsWritten written = close_recording(logs, path, summary.log_left, options.on_writing);
    std::vector<SensorStatus> sensors;
    for (const SensorWritten& sensor : written.sensors)
      sensors.push_back({sensor.name, sensor.body_frames, sensor.depth_frames, sensor.drops.at_source,
                         sensor.drops.in_queue + static_cast<std::int64_t>(sensor.left_out)});
    summary.last.sensors = std::move(sensors);
    for (const LogSummary& log : written.logs)
      summary.source_failed = summary.source_failed || !log.problem.empty();
  } catch (const OutputError& error) {
    throw OutputError(error.place(), error.problem() + ". The recording is whole in " +
                                         log_name(path).string() + ": make room, then " + remedy);
  }
  summary.session_bytes = std::filesystem::file_size(path);
  return summary;
}

namespace {

constexpr std::uint64_t kEventsBetweenLooks = 240;  // about a second of four sensors with depth and bodies

struct Store {
  SessionWriter& writer;
  const RecordOptions& options;
  RecordSummary& summary;
  std::size_t sensor;

  void operator()(const BodyFrame& frame) {
    writer.add_body_frame(sensor, frame);
    ++summary.body_frames;
  }
  void operator()(const DepthFrame& frame) {
    writer.add_depth_frame(sensor,
                           encode_depth_frame(frame.stamp, frame.depth_mm, options.depth_compression));
    ++summary.depth_frames;
  }
  void operator()(const SourceNotice&) {}
  void operator()(const ClockExchange& exchange) { writer.add_clock_exchange(sensor, exchange); }
  void operator()(const DropCount& count) { writer.add_drop_count(sensor, count); }
};

}  // namespace

RecordSummary record(FrameSource& source, const std::filesystem::path& path, const RecordOptions& options) {
  SessionWriter writer(path, source.header(), options.depth_compression);
  RecordSummary summary;
  std::uint64_t events = 0;
  while (auto event = source.next()) {
    std::visit(Store{writer, options, summary, event->sensor}, event->data);
    if (++events % kEventsBetweenLooks == 0 && options.stop_requested && options.stop_requested())
      throw Interrupted();
  }
  writer.finish();
  return summary;
}

}  // namespace trilat
