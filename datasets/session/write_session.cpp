// SPDX-License-Identifier: MIT
#include "datasets/session/write_session.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/session/clock/agent_clock.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_writer.h"

namespace trilat {
namespace {

struct OpenedLog {
  LogInput input;
  LogHead head;
  std::vector<std::size_t> sensors;  // of the session, by the log's own
};

// Nanoseconds since 1970 by the wall clock that the log began with.
std::int64_t unix_ns(const LogHead& head, std::int64_t monotonic_ns) {
  return head.start_unix_ns + (monotonic_ns - head.start_ns);
}

// The logs in the order of their beginning.
std::vector<OpenedLog> opened(const std::vector<LogInput>& inputs) {
  std::vector<OpenedLog> logs;
  for (const LogInput& input : inputs) {
    const std::string place = input.path.string();
    if (is_being_written(input.path))
      throw InputError(
          place,
          "is being written by a recording that still runs: end that first (Ctrl-C, or `kill -INT` "
          "its process)");
    logs.push_back({input, head_of_event_log(input.path), {}});
    for (std::size_t i = 0; i + 1 < logs.size(); ++i)
      if (logs[i].head.id == logs.back().head.id)
        throw InputError(place, fmt::format("is the same log as {}; give the longer one alone, which is {}",
                                            logs[i].input.path.string(),
                                            std::filesystem::file_size(place) >
                                                    std::filesystem::file_size(logs[i].input.path)
                                                ? "this one"
                                                : "the other"));
  }
  std::ranges::stable_sort(logs, {}, [](const OpenedLog& log) { return log.head.start_unix_ns; });
  return logs;
}

std::string name_in_session(const LogHead& head, std::size_t sensor) {
  if (head.agent.empty()) return head.session.sensors[sensor].name;
  return head.agent + (head.session.sensors.size() > 1 ? "-" + std::to_string(sensor + 1) : "");
}

bool are_of_one_source(const LogHead& a, const LogHead& b) {
  return a.agent.empty() ? b.agent.empty() && a.recording != 0 && a.recording == b.recording
                         : a.agent == b.agent;
}

// The sensors of all logs, those of one source once; simulated where one log is. Fills in where each log's
// sensors are.
SessionHeader joint_header(std::vector<OpenedLog>& logs) {
  SessionHeader header;
  std::vector<const LogHead*> owners;  // by sensor of the session
  for (OpenedLog& log : logs) {
    const SessionHeader& more = log.head.session;
    header.simulated = header.simulated || more.simulated;
    if (header.started_utc.empty()) header.started_utc = more.started_utc;
    if (header.note.find(more.note) == std::string::npos)
      header.note += (header.note.empty() ? "" : "; ") + more.note;
    for (std::size_t s = 0; s < more.sensors.size(); ++s) {
      SensorDescription sensor = more.sensors[s];
      sensor.name = name_in_session(log.head, s);
      std::size_t at = 0;
      while (at < owners.size() &&
             !(header.sensors[at].name == sensor.name && are_of_one_source(*owners[at], log.head)))
        ++at;
      log.sensors.push_back(at);
      if (at < owners.size()) continue;
      header.sensors.push_back(sensor);
      owners.push_back(&log.head);
    }
  }
  return header;
}

// Last frame of a stream of a sensor.
struct StreamEnd {
  std::int64_t unix_ns = 0;
  std::uint64_t log = 0;  // its id
};

// A sensor of the session while logs are written one after the other.
struct JoinedSensor {
  StreamEnd bodies, depth;
  DropCount before{};                            // lost in and between the logs before the present one
  std::int64_t shift_ns = 0;                     // added to monotonic times of the present log
  const OpenedLog* first = nullptr;              // log of this sensor
  std::optional<std::int64_t> first_shift_ns{};  // of that log against the first of all
};

// The agent's clock against the recorder's, as one log's exchanges say.
AgentClock clock_of(const OpenedLog& log) {
  std::vector<ClockExchange> exchanges;
  read_event_log(log.input.path, [&](std::size_t sensor, LogEvent&& event) {
    const auto* exchange = std::get_if<ClockExchange>(&event);
    if (exchange && sensor == 0 && is_plausible(*exchange)) exchanges.push_back(*exchange);
  });
  return fit_agent_clock(exchanges);
}

// Nanoseconds from the monotonic clock of a log to that of an earlier one, since a machine that was started
// anew has another. The exchanges with one recorder tell it, else the wall clock does.
std::int64_t shift_ns_between(const OpenedLog& log, const OpenedLog& first) {
  if (share_a_boot(log.head, first.head)) return 0;
  if (log.head.recording != 0 && log.head.recording == first.head.recording) {
    const AgentClock now = clock_of(log), before = clock_of(first);
    if (now.exchanges_used > 0 && before.exchanges_used > 0)
      return before.line.inverse()(now(now.first)).ns - now.first.ns;
  }
  return unix_ns(log.head, 0) - unix_ns(first.head, 0);
}

// Events of the logs into the session.
class LogCopy {
 public:
  LogCopy(SessionWriter& to, const SessionHeader& header, std::vector<SensorWritten>& written)
      : to_(to), header_(header), written_(written), joined_(header.sensors.size()) {}

  void begin(const OpenedLog& log) {
    log_ = &log;
    if (!first_log_) first_log_ = &log.head;
    // no exchanges tell how the clocks of computers stand that recorded alone
    const bool is_alone = log.head.recording == 0 && !log.head.agent.empty();
    for (const std::size_t s : log.sensors) {
      JoinedSensor& joined = joined_[s];
      if (!joined.first) joined.first = &log;
      if (!joined.first_shift_ns)
        joined.first_shift_ns = is_alone && log.head.agent != first_log_->agent
                                    ? unix_ns(log.head, 0) - unix_ns(*first_log_, 0)
                                    : 0;
      joined.before = written_[s].drops;
      joined.shift_ns = shift_ns_between(log, *joined.first) + *joined.first_shift_ns;
      if (*joined.first_shift_ns != 0)
        to_.add_notice(
            s,
            {0, "recorded alone: its clock is laid on the first log's by the wall clocks of both computers"});
    }
  }
  void take(std::size_t sensor, LogEvent&& event) {
    std::visit([&](auto& data) { add(log_->sensors[sensor], data); }, event);
  }
  // The present log said when its recording began.
  void note_begin(const LogSummary& log) {
    if (log.begin_unix_ns == 0 || begin_unix_ns_ != 0) return;
    begin_unix_ns_ = log.begin_unix_ns;
    recording_ = log.head.recording;
  }
  // Frames that are known to be missing behind the present log's end, and before a log of which no frame
  // came.
  void add_missing() {
    for (const std::size_t s : log_->sensors)
      for (StreamEnd* end : {&joined_[s].bodies, &joined_[s].depth})
        if (end->log != 0 && end->log != log_->head.id) count_gap(s, log_->head.start_unix_ns, *end);
    if (log_->input.missing_frames == 0 || log_->sensors.empty()) return;
    DropCount& drops = written_[log_->sensors[0]].drops;
    drops.in_queue += log_->input.missing_frames;
    to_.add_drop_count(log_->sensors[0], drops);
  }

 private:
  bool is_believable(std::size_t s, FrameStamp& stamp, StreamEnd& end) {
    if (!is_plausible(stamp, header_.sensors[s].tick_ns)) {
      ++written_[s].left_out;
      return false;
    }
    count_gap(s, unix_ns(log_->head, stamp.arrival_ns), end);
    stamp.arrival_ns += joined_[s].shift_ns;
    return true;
  }
  // Counts what was not recorded between two logs of a sensor as lost at the source.
  void count_gap(std::size_t s, std::int64_t now_unix_ns, StreamEnd& end) {
    constexpr double kOverlap_s = 1.0;  // clocks are corrected meanwhile
    constexpr double kStartUp_frames = 30.0;
    const double rate_hz = header_.sensors[s].nominal_rate_hz;
    const bool is_first = end.log == 0;
    if (is_first && (log_->head.agent.empty() || recording_ == 0 || log_->head.recording != recording_)) {
      // alone, or of the recorder itself: it is there from its beginning on
    } else if (end.log != log_->head.id) {
      const double gap_s =
          1e-9 * static_cast<double>(now_unix_ns - (is_first ? begin_unix_ns_ : end.unix_ns));
      if (!is_first && gap_s < -kOverlap_s)
        throw InputError(
            log_->input.path.string(),
            fmt::format("overlaps with another log of {} by {:.1f} s; join those that follow each other",
                        header_.sensors[s].name, -gap_s));
      const auto frames = static_cast<std::int64_t>(std::lround(gap_s * rate_hz)) - 1;
      if (frames > 0 && (!is_first || gap_s * rate_hz > kStartUp_frames)) {
        joined_[s].before.at_source += frames;
        written_[s].drops.at_source += frames;
        to_.add_drop_count(s, written_[s].drops);
        to_.add_notice(s,
                       {0, is_first ? fmt::format("the first {:.1f} s of the recording did not arrive", gap_s)
                                    : fmt::format("{:.1f} s between two logs were not recorded", gap_s)});
      }
    }
    end = {now_unix_ns, log_->head.id};
  }
  void add(std::size_t s, BodyFrame& frame) {
    if (!is_believable(s, frame.stamp, joined_[s].bodies)) return;
    to_.add_body_frame(s, frame);
    ++written_[s].body_frames;
  }
  void add(std::size_t s, EncodedDepthFrame& frame) {
    if (!is_believable(s, frame.stamp, joined_[s].depth)) return;
    try {
      if (!header_.sensors[s].has_depth) throw InputError("a depth frame", "is of a sensor without depth");
      to_.add_depth_frame(s, frame);
      ++written_[s].depth_frames;
    } catch (const OutputError&) {
      throw;
    } catch (const InputError&) {
      ++written_[s].left_out;
    }
  }
  void add(std::size_t s, ClockExchange& exchange) {
    if (!is_plausible(exchange)) return;
    exchange.t2_ns += joined_[s].shift_ns;
    exchange.t3_ns += joined_[s].shift_ns;
    to_.add_clock_exchange(s, exchange);
    ++written_[s].clock_exchanges;
  }
  void add(std::size_t s, DropCount& count) {
    const DropCount& before = joined_[s].before;
    written_[s].drops = {count.host_ns, before.at_source + count.at_source, before.in_queue + count.in_queue};
    to_.add_drop_count(s, written_[s].drops);
  }
  void add(std::size_t s, SensorNotice& notice) { to_.add_notice(s, notice); }

  SessionWriter& to_;
  const SessionHeader& header_;
  std::vector<SensorWritten>& written_;
  std::vector<JoinedSensor> joined_;
  const OpenedLog* log_ = nullptr;
  const LogHead* first_log_ = nullptr;
  std::int64_t begin_unix_ns_ = 0;  // of the recording, by its recorder
  std::uint64_t recording_ = 0;
};

// Message about how this log was read; empty where all is whole.
std::string state_of(const LogSummary& log) {
  std::uint64_t damaged = 0;
  for (const LogGap& gap : log.gaps) damaged += gap.bytes;
  std::string text;
  if (log.gap_count > 0)
    text = fmt::format(
        "{} bytes at {} places of its log are damaged, the first behind byte {}; what they held is left out",
        damaged, log.gap_count, log.gaps.front().offset);
  if (!log.finished)
    text +=
        (text.empty() ? "" : "; ") + std::string("recovered from a recording that was not ended in order");
  return text;
}

}  // namespace

bool LogsWritten::whole() const {
  return std::ranges::all_of(logs,
                             [](const LogSummary& log) {
                               return log.finished && log.gap_count == 0 && log.cut_bytes == 0;
                             }) &&
         std::ranges::all_of(sensors, [](const SensorWritten& sensor) { return sensor.left_out == 0; });
}

LogsWritten write_session(const std::vector<LogInput>& inputs, const std::filesystem::path& output,
                          const std::function<bool(double)>& progress) {
  check_output_file(output);
  std::vector<OpenedLog> logs = opened(inputs);
  const SessionHeader header = joint_header(logs);
  LogsWritten result;
  for (const SensorDescription& sensor : header.sensors) result.sensors.emplace_back().name = sensor.name;
  SessionWriter writer(output, header);
  LogCopy copy(writer, header, result.sensors);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    copy.begin(logs[i]);
    const auto part = [&](double share) {
      return !progress || progress((static_cast<double>(i) + share) / static_cast<double>(logs.size()));
    };
    const auto take = [&](std::size_t sensor, LogEvent&& event) { copy.take(sensor, std::move(event)); };
    result.logs.push_back(read_event_log(logs[i].input.path, take, part));
    copy.note_begin(result.logs.back());
    copy.add_missing();
    if (const std::string state = state_of(result.logs.back()); !state.empty())
      for (const std::size_t s : logs[i].sensors) writer.add_notice(s, {0, state});
  }
  writer.finish();
  return result;
}

namespace {

// Reads all frames of a session; throws InputError where one cannot be read.
void read_all(const SessionReader& session, const std::function<bool(double)>& progress) {
  constexpr std::uint64_t kAtOnce = 256;
  const std::size_t sensors = session.header().sensors.size();
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  for (std::size_t s = 0; s < sensors; ++s) {
    const SensorCounts& counts = session.counts(s);
    for (std::uint64_t i = 0; i < counts.body_frames; i += kAtOnce)
      (void)session.body_frames(s, i, std::min(kAtOnce, counts.body_frames - i));
    for (std::uint64_t i = 0; i < counts.depth_frames; ++i) {
      session.depth_frame(s, i, depth_mm);
      const double share = static_cast<double>(i) / static_cast<double>(counts.depth_frames);
      if (i % kAtOnce == 0 && progress &&
          !progress((static_cast<double>(s) + share) / static_cast<double>(sensors)))
        throw Interrupted();
    }
  }
}

}  // namespace

LogsWritten close_recording(const std::vector<LogInput>& logs, const std::filesystem::path& output,
                            std::string& left, const std::function<bool(double)>& progress) {
  const auto part = [&](double from, double share) { return !progress || progress(from + 0.5 * share); };
  const LogsWritten written = write_session(logs, output, [&](double share) { return part(0.0, share); });
  left = "not all of the log could be read back";
  for (const LogSummary& log : written.logs)
    if (log.gap_count > 0) return written;
  if (std::ranges::any_of(written.sensors, [](const SensorWritten& sensor) { return sensor.left_out > 0; }))
    return written;
  try {
    const SessionReader session(output);
    for (const SensorWritten& sensor : written.sensors) {
      const SensorCounts& counts = session.counts(session.sensor_index(sensor.name));
      if (counts.body_frames != sensor.body_frames || counts.depth_frames != sensor.depth_frames)
        throw InputError(output.string(), "does not hold all frames of the log");
    }
    read_all(session, [&](double share) { return part(0.5, share); });
  } catch (const InputError& error) {
    left = error.what();
    return written;
  }
  for (const LogInput& log : logs) std::filesystem::remove(log.path);
  left.clear();
  return written;
}

}  // namespace trilat
