// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "datasets/session/append_file.h"
#include "datasets/session/session_types.h"

// The event log (.trilog): what sensors delivered, appended record by record while it comes, so that a kill
// or a power cut costs what was not yet on the disk and nothing else. datasets/FORMATS.md describes its
// bytes.
namespace trilat {

using LogEvent = std::variant<BodyFrame, EncodedDepthFrame, ClockExchange, DropCount, SensorNotice>;

// First record of a log. `session.sensors` are counted from 0 in the records.
struct LogHead {
  std::uint64_t id = 0;            // one for each log
  std::uint64_t recording = 0;     // id of the recording that it is part of; 0: of none
  std::int64_t start_ns = 0;       // monotonic clock of the machine that writes the log
  std::int64_t start_unix_ns = 0;  // its wall clock at the same time
  std::string agent;               // name of the agent that wrote it; empty for a recorder
  SessionHeader session;
};

// Head of a log that begins now, with a new id.
LogHead new_log_head(const SessionHeader& session, std::uint64_t recording = 0,
                     const std::string& agent = {});

// Whether the machine was not started anew between two logs of it: by how their monotonic and wall clocks
// stand, to a minute.
bool share_a_boot(const LogHead& a, const LogHead& b);

// Bytes of a log that are not what was written, or not whole.
struct LogGap {
  std::uint64_t offset = 0, bytes = 0;
};

// Summary of a log whose bytes were read.
struct LogSummary {
  LogHead head;
  std::uint64_t records = 0;
  std::uint64_t end = 0;           // offset behind the last whole record
  std::uint64_t cut_bytes = 0;     // behind `end`: the beginning of a record, as a kill leaves it
  std::int64_t begin_unix_ns = 0;  // wall clock when its recording began; 0: of an agent, or before that
  bool finished = false;           // its writer ended it in order
  std::string problem;             // of a finished one: why its source ended, where that broke
  std::vector<LogGap> gaps;        // damaged bytes before `end`, the first kMaxLogGaps of them
  std::uint64_t gap_count = 0;
};
inline constexpr std::size_t kMaxLogGaps = 1000;

// Takes an event of a log and the sensor's index in its head.
using TakeEvent = std::function<void(std::size_t sensor, LogEvent&& event)>;

// Turns the bytes of a log into events, however they are cut into pieces. A record whose checksum or content
// is wrong is left out with all up to the next sound one. Never throws for any bytes but those of another
// format: InputError with `place` for a head that is no log's, or of another version.
class LogScanner {
 public:
  LogScanner(std::string place, TakeEvent take) : place_(std::move(place)), take_(std::move(take)) {}
  // Goes on behind the first `offset` bytes of a log with this head, which end with a whole record.
  LogScanner(std::string place, TakeEvent take, LogHead head, std::uint64_t offset);
  void feed(std::span<const std::byte> bytes);
  // No more will come: decides what the last bytes are. InputError when not even the head was whole.
  const LogSummary& finish();
  const LogSummary& summary() const { return summary_; }
  bool has_head() const { return has_head_; }

 private:
  void scan(bool at_end);
  bool take_magic(bool at_end);
  bool take_record(std::span<const std::byte> record);
  void note_gap();

  std::string place_;
  TakeEvent take_;
  LogSummary summary_;
  bool has_magic_ = false, has_head_ = false;
  std::vector<std::byte> pending_;  // not yet looked at
  std::uint64_t offset_ = 0;        // of pending_ in the log
  std::uint64_t given_up_ = 0;      // bytes before it that belong to no whole record
};

// Reads a whole log, which may grow meanwhile. InputError when it is none or cannot be read; Interrupted when
// `progress`, called with the share that was read, returns false.
LogSummary read_event_log(const std::filesystem::path& path, const TakeEvent& take,
                          const std::function<bool(double)>& progress = {});

// True for a file that begins as event logs do.
bool is_event_log(const std::filesystem::path& path);

// The first record of a log. InputError as in read_event_log().
LogHead head_of_event_log(const std::filesystem::path& path);

struct LogEnd {
  std::uint64_t offset = 0;  // behind the last whole record; 0 when not even the head is whole
  bool finished = false;     // that is the end in order
};

// Found from the end of the file: reads little more than the bytes behind its last mark, which are at most 64
// MB.
LogEnd end_of_event_log(const std::filesystem::path& path);

// Writes a new log. A thread of its own puts what was appended into the file at least every 50 ms and on the
// disk once a second. After an OutputError nothing more is written; what was synced stays.
class EventLogWriter {
 public:
  // Creates `path` and locks it while it is written. InputError when it exists.
  EventLogWriter(const std::filesystem::path& path, const LogHead& head);
  ~EventLogWriter();  // as a kill would leave it, but on the disk
  EventLogWriter(const EventLogWriter&) = delete;
  EventLogWriter& operator=(const EventLogWriter&) = delete;

  // Any thread. Waits while 64 MB wait for the disk. OutputError when the disk failed.
  void append(std::size_t sensor, const LogEvent& event);
  // From now on the recording that this log is of wants frames of all its agents.
  void begin();
  // Marks the log as ended in order and puts it on the disk. `problem`: why the source ended, where that
  // broke.
  void finish(const std::string& problem = {});

  // Gives the room of the first `bytes` of the file back to the disk.
  void release(std::uint64_t bytes) noexcept { file_.release(bytes); }

  std::uint64_t written_bytes() const;  // may be read from the file

 private:
  void append_record(std::uint8_t type, std::size_t sensor, std::span<const std::byte> payload);
  void write_and_sync();
  void end();

  AppendFile file_;
  std::uint64_t id_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::byte> gathered_;
  std::uint64_t appended_ = 0, written_ = 0, last_mark_ = 0;
  bool ended_ = false;
  std::string failure_;
  std::thread thread_;  // the last: it uses all of the above
};

}  // namespace trilat
