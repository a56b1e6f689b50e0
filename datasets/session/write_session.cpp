// SPDX-License-Identifier: MIT
#include "datasets/session/write_session.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_writer.h"

namespace trilat {
namespace {

// The sensors of all logs one behind the other; simulated where one of them is.
SessionHeader joint_header(const std::vector<LogHead>& heads) {
  SessionHeader header = heads.at(0).session;
  for (std::size_t i = 1; i < heads.size(); ++i) {
    const SessionHeader& more = heads[i].session;
    header.simulated = header.simulated || more.simulated;
    if (more.note != header.note) header.note += (header.note.empty() ? "" : "; ") + more.note;
    header.sensors.insert(header.sensors.end(), more.sensors.begin(), more.sensors.end());
  }
  return header;
}

std::vector<LogHead> heads_of(const std::vector<std::filesystem::path>& logs) {
  std::vector<LogHead> heads;
  for (const std::filesystem::path& path : logs) {
    if (is_being_written(path))
      throw InputError(path.string(),
                       "is being written by a recording that still runs: end that first (Ctrl-C, or "
                       "`kill -INT` its process)");
    heads.push_back(head_of_event_log(path));
    for (std::size_t i = 0; i + 1 < heads.size(); ++i)
      if (heads[i].id == heads.back().id)
        throw InputError(path.string(), "is the same log as " + logs[i].string() + "; give it once");
  }
  return heads;
}

// Events of one log into the session, where its first sensor has the index `first`.
class LogCopy {
 public:
  LogCopy(SessionWriter& to, const SessionHeader& header, std::size_t first,
          std::vector<SensorWritten>& written)
      : to_(to), header_(header), first_(first), written_(written) {}

  void take(std::size_t sensor, LogEvent&& event) {
    const std::size_t s = first_ + sensor;
    std::visit([&](auto& data) { add(s, data); }, event);
  }

 private:
  bool is_believable(std::size_t s, const FrameStamp& stamp) {
    const bool believable = is_plausible(stamp, header_.sensors[s].tick_ns);
    if (!believable) ++written_[s].left_out;
    return believable;
  }
  void add(std::size_t s, BodyFrame& frame) {
    if (!is_believable(s, frame.stamp)) return;
    to_.add_body_frame(s, frame);
    ++written_[s].body_frames;
  }
  void add(std::size_t s, EncodedDepthFrame& frame) {
    if (!is_believable(s, frame.stamp)) return;
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
    to_.add_clock_exchange(s, exchange);
    ++written_[s].clock_exchanges;
  }
  void add(std::size_t s, DropCount& count) {
    to_.add_drop_count(s, count);
    written_[s].drops = count;
  }
  void add(std::size_t s, SensorNotice& notice) { to_.add_notice(s, notice); }

  SessionWriter& to_;
  const SessionHeader& header_;
  std::size_t first_;
  std::vector<SensorWritten>& written_;
};

// What a person should know of how this log was read; empty where all is whole.
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

LogsWritten write_session(const std::vector<std::filesystem::path>& logs, const std::filesystem::path& output,
                          const std::function<bool(double)>& progress) {
  check_output_file(output);
  const std::vector<LogHead> heads = heads_of(logs);
  const SessionHeader header = joint_header(heads);
  LogsWritten result;
  for (const SensorDescription& sensor : header.sensors) result.sensors.emplace_back().name = sensor.name;
  SessionWriter writer(output, header);
  std::size_t first = 0;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    LogCopy copy(writer, header, first, result.sensors);
    const auto part = [&](double share) {
      return !progress || progress((static_cast<double>(i) + share) / static_cast<double>(logs.size()));
    };
    result.logs.push_back(read_event_log(
        logs[i], [&](std::size_t s, LogEvent&& event) { copy.take(s, std::move(event)); }, part));
    const std::size_t sensors = heads[i].session.sensors.size();
    if (const std::string state = state_of(result.logs.back()); !state.empty())
      for (std::size_t s = 0; s < sensors; ++s) writer.add_notice(first + s, {0, state});
    first += sensors;
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

std::string close_recording(const std::vector<std::filesystem::path>& logs,
                            const std::filesystem::path& output,
                            const std::function<bool(double)>& progress) {
  const auto part = [&](double from, double share) { return !progress || progress(from + 0.5 * share); };
  const LogsWritten written = write_session(logs, output, [&](double share) { return part(0.0, share); });
  if (!written.whole()) return "not all of the log could be read back";
  try {
    const SessionReader session(output);
    for (std::size_t s = 0; s < written.sensors.size(); ++s)
      if (session.counts(s).body_frames != written.sensors[s].body_frames ||
          session.counts(s).depth_frames != written.sensors[s].depth_frames)
        return output.string() + " does not hold all frames of the log";
    read_all(session, [&](double share) { return part(0.5, share); });
  } catch (const InputError& error) {
    return error.what();
  }
  for (const std::filesystem::path& log : logs) std::filesystem::remove(log);
  return {};
}

}  // namespace trilat
