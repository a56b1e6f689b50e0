// SPDX-License-Identifier: MIT
#include "datasets/session/event_log.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <random>
#include <utility>

#include <zlib.h>

#include "datasets/base/error.h"
#include "datasets/session/event_bytes.h"
#include "datasets/session/host_clock.h"

namespace trilat {
namespace {

// A log is kLogMagic and records. A record is the length of its payload (u32), type (u8), sensor (u8), kSync
// (u16), the payload, and crc32 of all before (u32).
constexpr char kLogMagic[8] = {'T', 'R', 'I', 'L', 'O', 'G', '1', '\n'};
constexpr std::uint16_t kSync = 0x4c54;  // "TL": where a damaged record is left behind, another may begin
constexpr std::size_t kRecordHead = 8, kRecordFrame = kRecordHead + 4;
constexpr std::size_t kMaxPayload = std::size_t{1} << 20;  // a raw depth frame has 434,176 bytes
constexpr std::uint64_t kMarkPeriod = std::uint64_t{64} << 20;
constexpr std::size_t kBlock = std::size_t{1} << 20;  // read or written at once

enum RecordType : std::uint8_t {
  kHeadRecord = 1,
  kBodiesRecord,
  kDepthRecord,
  kExchangeRecord,
  kDropsRecord,
  kNoticeRecord,
  kMarkRecord,
  kEndRecord,
  kBeginRecord
};

struct MarkRecord {
  std::uint64_t id = 0, offset = 0;  // of the log; of the mark in it
};
struct EndRecord {
  std::string problem;
};
struct BeginRecord {
  std::int64_t unix_ns = 0;
};

void pass(auto& bytes, Is<LogHead> auto& head) {
  bytes.number(head.id);
  bytes.number(head.recording);
  bytes.number(head.start_ns);
  bytes.number(head.start_unix_ns);
  bytes.text(head.agent, kMaxNameBytes);
  bytes.flag(head.session.simulated);
  bytes.text(head.session.started_utc, kMaxTextBytes);
  bytes.text(head.session.note, kMaxTextBytes);
  bytes.list(head.session.sensors, kMaxSessionSensors, [&](auto& sensor) { pass(bytes, sensor); });
}
void pass(auto& bytes, Is<ClockExchange> auto& e) {
  for (auto* t : {&e.t1_ns, &e.t2_ns, &e.t3_ns, &e.t4_ns}) bytes.number(*t);
}
void pass(auto& bytes, Is<DropCount> auto& drops) {
  bytes.number(drops.host_ns);
  bytes.count(drops.at_source);
  bytes.count(drops.in_queue);
}
void pass(auto& bytes, Is<SensorNotice> auto& notice) {
  bytes.number(notice.host_ns);
  bytes.text(notice.text, kMaxTextBytes);
}
void pass(auto& bytes, Is<MarkRecord> auto& mark) {
  bytes.number(mark.id);
  bytes.number(mark.offset);
}
void pass(auto& bytes, Is<BeginRecord> auto& begin) { bytes.number(begin.unix_ns); }
void pass(auto& bytes, Is<EndRecord> auto& end) { bytes.text(end.problem, kMaxTextBytes); }

std::vector<std::byte> bytes_of(const auto& value) {
  ByteWriter out;
  Put put{out};
  pass(put, value);
  return out.take();
}

// Value of a payload; nothing when it is not that of a T.
template <class T>
std::optional<T> value_of(std::span<const std::byte> payload) {
  ByteReader in(payload);
  Get get{in};
  T value;
  pass(get, value);
  return in.failed() || in.left() != 0 ? std::nullopt : std::optional<T>(std::move(value));
}

// Type of the record of an event, by its place in the variant.
std::uint8_t type_of(const LogEvent& event) {
  return static_cast<std::uint8_t>(kBodiesRecord + event.index());
}

std::optional<LogEvent> event_of(std::uint8_t type, std::span<const std::byte> payload) {
  const auto read = [&]<class T>(T) -> std::optional<LogEvent> {
    auto value = value_of<T>(payload);
    return value ? std::optional<LogEvent>(std::move(*value)) : std::nullopt;
  };
  switch (type) {
    case kBodiesRecord:
      return read(BodyFrame{});
    case kDepthRecord:
      return read(EncodedDepthFrame{});
    case kExchangeRecord:
      return read(ClockExchange{});
    case kDropsRecord:
      return read(DropCount{});
    case kNoticeRecord:
      return read(SensorNotice{});
  }
  return std::nullopt;
}

std::uint32_t crc_of(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

std::vector<std::byte> record_of(std::uint8_t type, std::size_t sensor, std::span<const std::byte> payload) {
  TRILAT_CHECK(payload.size() <= kMaxPayload && sensor < kMaxSessionSensors, "a record keeps its limits");
  ByteWriter out;
  out.put(static_cast<std::uint32_t>(payload.size()));
  out.put(type);
  out.put(static_cast<std::uint8_t>(sensor));
  out.put(kSync);
  out.put_bytes(payload);
  std::vector<std::byte> record = out.take();
  ByteWriter sum;
  sum.put(crc_of(record));
  for (const std::byte byte : sum.take()) record.push_back(byte);
  return record;
}

enum class Look { whole, more_needed, damaged };

// Finds what the bytes begin with; of a whole record its size, too.
Look look_at(std::span<const std::byte> bytes, std::size_t& size) {
  if (bytes.size() < kRecordHead) return Look::more_needed;
  ByteReader in(bytes);
  const auto length = in.get<std::uint32_t>();
  const auto type = in.get<std::uint8_t>();
  in.get<std::uint8_t>();
  if (in.get<std::uint16_t>() != kSync || length > kMaxPayload || type < kHeadRecord || type > kBeginRecord)
    return Look::damaged;
  size = kRecordFrame + length;
  if (bytes.size() < size) return Look::more_needed;
  ByteReader sum(bytes.subspan(size - 4));
  return sum.get<std::uint32_t>() == crc_of(bytes.first(size - 4)) ? Look::whole : Look::damaged;
}

bool is_believable(const LogHead& head) {
  return std::ranges::all_of(head.session.sensors,
                             [](const auto& sensor) { return problem_with(sensor).empty(); });
}

std::int64_t unix_now_ns() {
  const auto since_epoch = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(since_epoch).count();
}

}  // namespace

LogHead new_log_head(const SessionHeader& session, std::uint64_t recording, const std::string& agent) {
  std::random_device device;
  return {std::uint64_t{device()} << 32 | device(), recording, host_now_ns(), unix_now_ns(), agent, session};
}

bool share_a_boot(const LogHead& a, const LogHead& b) {
  constexpr std::int64_t kClockStep_ns = 60'000'000'000;  // what setting the wall clock may do
  return std::abs((a.start_unix_ns - a.start_ns) - (b.start_unix_ns - b.start_ns)) < kClockStep_ns;
}

LogScanner::LogScanner(std::string place, TakeEvent take, LogHead head, std::uint64_t offset)
    : place_(std::move(place)), take_(std::move(take)), has_magic_(true), has_head_(true), offset_(offset) {
  summary_.head = std::move(head);
  summary_.end = offset;
}

void LogScanner::feed(std::span<const std::byte> bytes) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  scan(false);
}

const LogSummary& LogScanner::finish() {
  scan(true);
  if (!has_head_) throw InputError(place_, "ends before its head: nothing was recorded in it");
  summary_.cut_bytes = given_up_ + pending_.size();
  return summary_;
}

bool LogScanner::take_magic(bool at_end) {
  if (pending_.size() < sizeof kLogMagic && !at_end) return false;
  if (pending_.size() < sizeof kLogMagic || std::memcmp(pending_.data(), kLogMagic, 6) != 0)
    throw InputError(place_, "is not a log of this program");
  if (std::memcmp(pending_.data(), kLogMagic, sizeof kLogMagic) != 0)
    throw InputError(place_, "is a log of another format than version 1, which this program reads");
  pending_.erase(pending_.begin(), pending_.begin() + sizeof kLogMagic);
  summary_.end = offset_ = sizeof kLogMagic;
  return has_magic_ = true;
}

void LogScanner::scan(bool at_end) {
  if (!has_magic_ && !take_magic(at_end)) return;
  std::size_t at = 0;
  while (at < pending_.size()) {
    std::size_t size = 0;
    const auto rest = std::span<const std::byte>(pending_).subspan(at);
    const Look found = look_at(rest, size);
    // at the end of a file, a length that reaches behind it may be damaged, and sound records lie in what is
    // left
    if (found == Look::more_needed && !at_end) break;
    if (found == Look::whole && take_record(rest.first(size))) {
      if (given_up_ > 0) note_gap();
      at += size;
      summary_.end = offset_ + at;
      ++summary_.records;
    } else {
      ++at;
      ++given_up_;
    }
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(at));
  offset_ += at;
}

void LogScanner::note_gap() {
  ++summary_.gap_count;
  if (summary_.gaps.size() < kMaxLogGaps) summary_.gaps.push_back({summary_.end, given_up_});
  given_up_ = 0;
}

// False when the content of a record with a right checksum is none.
bool LogScanner::take_record(std::span<const std::byte> record) {
  const auto type = std::to_integer<std::uint8_t>(record[4]);
  const auto sensor = std::to_integer<std::size_t>(record[5]);
  const auto payload = record.subspan(kRecordHead, record.size() - kRecordFrame);
  if (type == kHeadRecord) {
    auto head = value_of<LogHead>(payload);
    if (has_head_ || !head || !is_believable(*head)) return false;
    summary_.head = std::move(*head);
    return has_head_ = true;
  }
  if (!has_head_) return false;
  if (type == kMarkRecord) return value_of<MarkRecord>(payload).has_value();
  if (type == kBeginRecord) {
    const auto begin = value_of<BeginRecord>(payload);
    if (begin && summary_.begin_unix_ns == 0) summary_.begin_unix_ns = begin->unix_ns;
    return begin.has_value();
  }
  if (type == kEndRecord) {
    const auto end = value_of<EndRecord>(payload);
    if (!end) return false;
    summary_.problem = end->problem;
    return summary_.finished = true;
  }
  auto event = event_of(type, payload);
  if (!event || sensor >= summary_.head.session.sensors.size()) return false;
  take_(sensor, std::move(*event));
  return true;
}

LogSummary read_event_log(const std::filesystem::path& path, const TakeEvent& take,
                          const std::function<bool(double)>& progress) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string(), "cannot be read");
  const auto size = static_cast<double>(std::filesystem::file_size(path));
  LogScanner scanner(path.string(), take);
  std::vector<char> block(kBlock);
  for (double read = 0.0; file; read += static_cast<double>(file.gcount())) {
    if (progress && !progress(std::min(1.0, read / size))) throw Interrupted();
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    scanner.feed(std::as_bytes(std::span(block).first(static_cast<std::size_t>(file.gcount()))));
  }
  if (file.bad()) throw InputError(path.string(), "cannot be read to its end");
  return scanner.finish();
}

bool is_event_log(const std::filesystem::path& path) {
  std::string begin(6, '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return begin == "TRILOG";
}

LogHead head_of_event_log(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string(), "cannot be read");
  LogScanner scanner(path.string(), [](std::size_t, LogEvent&&) {});
  std::vector<char> block(1u << 16);  // holds kMaxSessionSensors descriptions
  while (file && !scanner.has_head()) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    scanner.feed(std::as_bytes(std::span(block).first(static_cast<std::size_t>(file.gcount()))));
  }
  return scanner.has_head() ? scanner.summary().head : scanner.finish().head;
}

namespace {

// The end by the records that follow the first mark at or behind `from`; offset 0 when there is no such mark.
LogEnd end_behind_mark(std::ifstream& file, std::uint64_t from) {
  file.clear();
  file.seekg(static_cast<std::streamoff>(from));
  std::vector<std::byte> bytes;
  for (std::array<char, 1 << 16> block; file;) {
    file.read(block.data(), block.size());
    const auto read = std::as_bytes(std::span(block).first(static_cast<std::size_t>(file.gcount())));
    bytes.insert(bytes.end(), read.begin(), read.end());
  }
  LogEnd end;
  for (std::size_t at = 0; at < bytes.size();) {
    std::size_t size = 0;
    const auto rest = std::span<const std::byte>(bytes).subspan(at);
    const bool is_whole = look_at(rest, size) == Look::whole;
    const auto type = is_whole ? std::to_integer<std::uint8_t>(rest[4]) : std::uint8_t{0};
    if (end.offset == 0 && type == kMarkRecord) {
      const auto mark = value_of<MarkRecord>(rest.subspan(kRecordHead, size - kRecordFrame));
      if (mark && mark->offset == from + at) end.offset = from + at;
    }
    const bool is_taken = is_whole && end.offset != 0;
    if (is_taken) end = {from + at + size, type == kEndRecord};
    at += is_taken ? size : 1;
  }
  return end;
}

}  // namespace

LogEnd end_of_event_log(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string(), "cannot be read");
  constexpr std::uint64_t kTail = kMarkPeriod + 2 * kMaxPayload;
  const std::uint64_t size = std::filesystem::file_size(path);
  if (size > kTail)
    if (const LogEnd end = end_behind_mark(file, size - kTail); end.offset != 0) return end;
  try {
    const LogSummary log = read_event_log(path, [](std::size_t, LogEvent&&) {});
    return {log.end, log.finished};
  } catch (const InputError&) {
    return {};
  }
}

EventLogWriter::EventLogWriter(const std::filesystem::path& path, const LogHead& head)
    : file_(path, AppendFile::Open::create), id_(head.id) {
  const std::vector<std::byte> record = record_of(kHeadRecord, 0, bytes_of(head));
  gathered_.assign(reinterpret_cast<const std::byte*>(kLogMagic),
                   reinterpret_cast<const std::byte*>(kLogMagic) + sizeof kLogMagic);
  gathered_.insert(gathered_.end(), record.begin(), record.end());
  appended_ = gathered_.size();
  thread_ = std::thread([this] { write_and_sync(); });
}

EventLogWriter::~EventLogWriter() { end(); }

void EventLogWriter::end() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void EventLogWriter::append(std::size_t sensor, const LogEvent& event) {
  append_record(type_of(event), sensor, std::visit([](const auto& data) { return bytes_of(data); }, event));
}

void EventLogWriter::append_record(std::uint8_t type, std::size_t sensor,
                                   std::span<const std::byte> payload) {
  const std::vector<std::byte> record = record_of(type, sensor, payload);
  constexpr std::size_t kMaxWaiting_bytes = std::size_t{64} << 20;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return gathered_.size() < kMaxWaiting_bytes || !failure_.empty(); });
  if (!failure_.empty()) throw OutputError(file_.path().string(), failure_);
  TRILAT_CHECK(!ended_, "nothing is appended behind the end");
  const auto add = [&](const std::vector<std::byte>& bytes) {
    gathered_.insert(gathered_.end(), bytes.begin(), bytes.end());
    appended_ += bytes.size();
  };
  if (appended_ + record.size() - last_mark_ > kMarkPeriod) {
    last_mark_ = appended_;
    add(record_of(kMarkRecord, 0, bytes_of(MarkRecord{id_, appended_})));
  }
  add(record);
  if (gathered_.size() >= kBlock) changed_.notify_all();
}

void EventLogWriter::begin() { append_record(kBeginRecord, 0, bytes_of(BeginRecord{unix_now_ns()})); }

void EventLogWriter::finish(const std::string& problem) {
  append_record(kEndRecord, 0, bytes_of(EndRecord{problem}));
  end();
  if (!failure_.empty()) throw OutputError(file_.path().string(), failure_);
}

void EventLogWriter::write_and_sync() {
  using Clock = std::chrono::steady_clock;
  constexpr auto kWritePeriod = std::chrono::milliseconds(50);
  constexpr auto kSyncPeriod = std::chrono::seconds(1);
  Clock::time_point last_sync = Clock::now();
  std::vector<std::byte> block;
  std::unique_lock lock(mutex_);
  try {
    for (bool last = false; !last;) {
      changed_.wait_for(lock, kWritePeriod, [&] { return ended_ || gathered_.size() >= kBlock; });
      last = ended_;
      block.clear();
      block.swap(gathered_);
      std::uint64_t written = written_;
      lock.unlock();
      changed_.notify_all();  // there is room again
      file_.append(block);
      written += block.size();
      if (last || Clock::now() - last_sync >= kSyncPeriod) {
        file_.sync();
        last_sync = Clock::now();
      }
      lock.lock();
      written_ = written;
    }
  } catch (const OutputError& error) {
    if (!lock.owns_lock()) lock.lock();
    failure_ = error.problem();
    gathered_.clear();
    changed_.notify_all();
  }
}

std::uint64_t EventLogWriter::written_bytes() const {
  const std::lock_guard lock(mutex_);
  return written_;
}

}  // namespace trilat
