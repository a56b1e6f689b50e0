// SPDX-License-Identifier: MIT
#include "datasets/synthetic/tracker/tracker_truth.h"

#include <algorithm>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "datasets/hdf5/hdf5_file.h"
#include "datasets/session/session_types.h"

namespace trilat {
namespace {

constexpr const char* kTruthFormat = "trilat.tracker_truth";
constexpr std::int64_t kVersion = 1;
constexpr std::size_t kRowsPerChunk = 4096;

struct Tables {
  H5Table sequence, hidden, exchanged, tracking_id;
};

template <class Table>
Tables tables_of(const Table& table) {
  return {table("sequence", H5Type::i64), table("hidden", H5Type::u32), table("exchanged", H5Type::u8),
          table("tracking_id", H5Type::u64)};
}

template <class T, class Value>
void append_column(H5Table& table, const std::vector<TrackerTruth>& rows, const Value& value) {
  std::vector<T> column;
  column.reserve(rows.size());
  for (const TrackerTruth& row : rows) column.push_back(static_cast<T>(value(row)));
  table.append(std::span<const T>(column));
}

template <class T>
std::vector<T> column_of(const H5Table& table, std::uint64_t first, std::uint64_t count) {
  std::vector<T> values(count);
  table.read(first, std::span<T>(values));
  return values;
}

[[noreturn]] void refuse(const H5Table& table, std::uint64_t row, const std::string& problem) {
  throw InputError(table.place(), fmt::format("row {}: {}", row, problem));
}

}  // namespace

struct TrackerTruthWriter::State {
  struct Sensor {
    Tables tables;
    std::vector<TrackerTruth> rows;
    void flush() {
      append_column<std::int64_t>(tables.sequence, rows, [](const auto& r) { return r.sequence; });
      append_column<std::uint32_t>(tables.hidden, rows, [](const auto& r) { return r.hidden; });
      append_column<std::uint8_t>(tables.exchanged, rows, [](const auto& r) { return r.exchanged; });
      append_column<std::uint64_t>(tables.tracking_id, rows, [](const auto& r) { return r.tracking_id; });
      rows.clear();
    }
  };
  std::filesystem::path path;
  H5File file;
  std::vector<Sensor> sensors;
};

TrackerTruthWriter::TrackerTruthWriter(const std::filesystem::path& path,
                                       const std::vector<std::string>& sensors)
    : state_(std::make_unique<State>()) {
  state_->path = path;
  state_->file = H5File::create(partial_name(path));
  state_->file.set_text("format", kTruthFormat);
  state_->file.set_integer("version", kVersion);
  state_->file.set_text("created_by", kProgramVersion);
  H5Node group = state_->file.create_group("sensors");
  for (const std::string& name : sensors) {
    H5Node node = group.create_group(name);
    state_->sensors.push_back({tables_of([&](const char* table, H5Type type) {
                                 return node.create_table(table, type, {},
                                                          {.chunk_rows = kRowsPerChunk, .checksum = true});
                               }),
                               {}});
  }
}

TrackerTruthWriter::~TrackerTruthWriter() = default;

void TrackerTruthWriter::append(std::size_t sensor, const TrackerTruth& truth) {
  State::Sensor& s = state_->sensors.at(sensor);
  s.rows.push_back(truth);
  if (s.rows.size() == kRowsPerChunk) s.flush();
}

void TrackerTruthWriter::finish() {
  for (State::Sensor& sensor : state_->sensors) sensor.flush();
  state_->sensors.clear();
  state_->file.close();
  publish_file(partial_name(state_->path), state_->path);
}

struct TrackerTruthReader::State {
  H5File file;
  std::vector<std::string> names;
  std::vector<Tables> tables;
  const Tables& of(const std::string& sensor) const {
    const auto found = std::ranges::find(names, sensor);
    if (found == names.end()) throw InputError(file.place(), "has no sensor \"" + sensor + "\"");
    return tables[static_cast<std::size_t>(found - names.begin())];
  }
};

TrackerTruthReader::TrackerTruthReader(const std::filesystem::path& path)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.file = H5File::open(path);
  if (!s.file.has_attribute("format") || s.file.text("format") != kTruthFormat)
    throw InputError(path.string(), "is no tracker truth of this program");
  if (s.file.integer("version") != kVersion)
    throw InputError(path.string(), "is a tracker truth of another format version");
  const H5Node group = s.file.group("sensors");
  s.names = group.children(kMaxSessionSensors);
  for (const std::string& name : s.names) {
    const H5Node node = group.group(name);
    Tables tables = tables_of([&](const char* table, H5Type type) { return node.table(table, type, {}); });
    for (const H5Table* table : {&tables.hidden, &tables.exchanged, &tables.tracking_id})
      if (table->rows() != tables.sequence.rows())
        throw InputError(table->place(), fmt::format("has {} rows, but sequence has {}", table->rows(),
                                                     tables.sequence.rows()));
    s.tables.push_back(std::move(tables));
  }
}

TrackerTruthReader::~TrackerTruthReader() = default;

const std::vector<std::string>& TrackerTruthReader::sensors() const { return state_->names; }

std::uint64_t TrackerTruthReader::frames(const std::string& sensor) const {
  return state_->of(sensor).sequence.rows();
}

std::vector<TrackerTruth> TrackerTruthReader::read(const std::string& sensor, std::uint64_t first,
                                                   std::uint64_t count) const {
  const Tables& t = state_->of(sensor);
  TRILAT_CHECK(first <= t.sequence.rows() && count <= t.sequence.rows() - first, "rows lie in the file");
  const auto sequence = column_of<std::int64_t>(t.sequence, first, count);
  const auto hidden = column_of<std::uint32_t>(t.hidden, first, count);
  const auto exchanged = column_of<std::uint8_t>(t.exchanged, first, count);
  const auto tracking_id = column_of<std::uint64_t>(t.tracking_id, first, count);
  std::vector<TrackerTruth> rows(count);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i > 0 && sequence[i] <= sequence[i - 1]) refuse(t.sequence, first + i, "does not rise");
    if (hidden[i] >> kJointCount != 0) refuse(t.hidden, first + i, "has bits that are no joints");
    if (exchanged[i] > 1) refuse(t.exchanged, first + i, "must be 0 or 1");
    rows[i] = {sequence[i], hidden[i], exchanged[i] == 1, tracking_id[i]};
  }
  return rows;
}

}  // namespace trilat
