// SPDX-License-Identifier: MIT
#include "datasets/results/stored_take.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "datasets/hdf5/hdf5_file.h"

namespace trilat {
namespace {

constexpr const char* kTakeFormat = "trilat.take";
constexpr double kBinGrowth = 1.005;
constexpr std::int64_t kTakeVersion = 4;
constexpr std::int64_t kMaxNs = std::int64_t{1} << 61;  // so that differences of two times cannot overflow
constexpr std::size_t kMaxEstimates = 1u << 14;         // of an instant: blocks of instants are read whole
constexpr std::size_t kMaxSensors = 64;                 // each a track, where sensors are left out in turn
constexpr std::uint64_t kTogether = 256;                // instants whose samples are compressed together
constexpr std::uint64_t kRowsTogether = 16384;          // rows of a table

struct SampleTables {
  H5Table time_ns, heading_rad, truth_m, ranges, occluded, estimate_m, status, iterations, cost_m2, gdop;
};

// Rows that are compressed together, of so many bytes each.
H5Layout compressed(std::uint64_t row_bytes, std::uint64_t rows, std::uint64_t together) {
  constexpr std::uint64_t kChunkBytes = 4 << 20;
  const std::uint64_t most = std::max<std::uint64_t>(1, std::min(together, kChunkBytes / row_bytes));
  return {.chunk_rows = static_cast<std::size_t>(std::clamp<std::uint64_t>(rows, 1, most)),
          .compression = ChunkCompression::deflate,
          .shuffle = true};
}

// Makes or opens one table of a take.
template <class Table>
SampleTables tables_of(std::uint64_t joints, std::uint64_t methods, const Table& table) {
  return {table("time_ns", H5Type::i64, {}),
          table("heading_rad", H5Type::f32, {}),
          table("truth_m", H5Type::f64, {joints, 3}),
          table("ranges", H5Type::u8, {joints}),
          table("occluded", H5Type::u8, {joints}),
          table("estimate_m", H5Type::f32, {joints, methods, 3}),
          table("status", H5Type::u8, {joints, methods}),
          table("iterations", H5Type::u32, {joints, methods}),
          table("cost_m2", H5Type::f32, {joints, methods}),
          table("gdop", H5Type::f32, {joints, methods})};
}

using Shape = std::vector<std::uint64_t>;

// The truth's positions and times are noise in their last digits, and stored as they are.
H5Layout layout_of(const std::string& table, const Shape& row_shape, const TakeHead& head) {
  if (table == "truth_m" || table == "time_ns") return {};
  std::uint64_t elements = 1;
  for (const std::uint64_t extent : row_shape) elements *= extent;
  return compressed(std::max<std::uint64_t>(1, elements * sizeof(float)), head.instants, kTogether);
}

std::string position_attribute(std::size_t axis) { return fmt::format("sensor_{}_m", "xyz"[axis]); }

void check_block(const SampleBlock& block, const SampleTables& t, std::size_t statuses) {
  const auto [first, last] = std::minmax_element(block.time_ns.begin(), block.time_ns.end());
  if (first != block.time_ns.end() && (*first < -kMaxNs || *last > kMaxNs))
    throw InputError(t.time_ns.place(), "holds a time beyond 73 years, which no clock shows");
  const auto status = std::ranges::max_element(block.status);
  if (status != block.status.end() && *status >= statuses)
    throw InputError(t.status.place(), fmt::format("holds the status {}, which has no name", *status));
}

// The numbers of a row: those that count, as u32, and those that measure, as f64. A list of three is along x,
// y and z, any other is numbered.
struct RowColumns {
  struct Column {
    std::string name;
    std::size_t offset;
  };
  std::vector<Column> counts, sums;

  template <class Row>
  static RowColumns of() {
    RowColumns columns;
    const Row row;
    Row::fields(row, EachField{[&](const char* name, const auto& member) {
                  const auto offset = static_cast<std::size_t>(reinterpret_cast<const char*>(&member) -
                                                               reinterpret_cast<const char*>(&row));
                  columns.add(name, member, offset);
                }});
    return columns;
  }

 private:
  void add(const std::string& name, std::uint32_t, std::size_t offset) { counts.push_back({name, offset}); }
  void add(const std::string& name, double, std::size_t offset) { sums.push_back({name, offset}); }
  template <class T, std::size_t n>
  void add(const std::string& name, const std::array<T, n>& list, std::size_t offset) {
    for (std::size_t k = 0; k < n; ++k)
      add(fmt::format("{}_{}", name, n == 3 ? std::string(1, "xyz"[k]) : std::to_string(k)), list[k],
          offset + k * sizeof(T));
  }
};

std::vector<std::string> names_of(const std::vector<RowColumns::Column>& columns) {
  std::vector<std::string> names;
  for (const RowColumns::Column& column : columns) names.push_back(column.name);
  return names;
}

// A table of such rows is a group of two: `counts` and `sums`, whose columns are named by its attributes.
template <class Row>
void write_rows(H5Node& parent, const char* name, const std::vector<Row>& rows) {
  const RowColumns columns = RowColumns::of<Row>();
  H5Node node = parent.create_group(name);
  const auto write = [&](const char* part, const std::vector<RowColumns::Column>& of, auto number) {
    node.set_texts(std::string(part) + "_columns", names_of(of));
    std::vector<decltype(number)> values;
    values.reserve(rows.size() * of.size());
    for (const Row& row : rows)
      for (const RowColumns::Column& column : of) {
        std::memcpy(&number, reinterpret_cast<const char*>(&row) + column.offset, sizeof(number));
        values.push_back(number);
      }
    const H5Layout layout =
        rows.empty() ? H5Layout{} : compressed(of.size() * sizeof(number), rows.size(), kRowsTogether);
    H5Table table = node.create_table(part, h5_type_of<decltype(number)>(), {of.size()}, layout, rows.size());
    if (!rows.empty()) table.write(0, std::span<const decltype(number)>(values));
  };
  write("counts", columns.counts, std::uint32_t{0});
  if (!columns.sums.empty()) write("sums", columns.sums, 0.0);
}

template <class Row>
std::vector<Row> read_rows(const H5Node& parent, const char* name) {
  const RowColumns columns = RowColumns::of<Row>();
  const H5Node node = parent.group(name);
  std::vector<Row> rows;
  const auto read = [&](const char* part, const std::vector<RowColumns::Column>& of, auto number) {
    const H5Table table = node.table(part, h5_type_of<decltype(number)>(), {of.size()});
    if (part == std::string("counts")) rows.resize(table.rows());
    if (rows.size() != table.rows()) throw InputError(node.place(), "counts and sums differ in length");
    std::vector<decltype(number)> values(rows.size() * of.size());
    if (!values.empty()) table.read(0, std::span<decltype(number)>(values));
    auto value = values.begin();
    for (Row& row : rows)
      for (const RowColumns::Column& column : of) {
        std::memcpy(reinterpret_cast<char*>(&row) + column.offset, &*value, sizeof(number));
        ++value;
      }
  };
  read("counts", columns.counts, std::uint32_t{0});
  if (!columns.sums.empty()) read("sums", columns.sums, 0.0);
  return rows;
}

// Refuses rows that name what the take does not have: readers use the numbers as places. The truth is a
// method, and "before any" an alignment, of sums alone.
void check_places(const TakeErrors& t, const TakeHead& head, const std::string& place) {
  const auto all = [&](const auto& rows, std::size_t more, const char* what) {
    for (const auto& row : rows) {
      bool is_right = row.quantity < t.quantities.size() && row.method < head.methods.size() + more;
      if constexpr (requires { row.alignment; })
        is_right = is_right && row.alignment < t.alignments.size() + more;
      if constexpr (requires { row.subset; }) is_right = is_right && row.subset < kSubsetNames.size();
      if constexpr (requires { row.measure; }) is_right = is_right && row.measure < kMeasureNames.size();
      if constexpr (requires { row.test; }) is_right = is_right && row.test < 2;
      if (!is_right)
        throw InputError(place + "/" + what,
                         "has a row of a joint, method or alignment that the take has not");
    }
  };
  if (t.quantities.size() < head.tracks.size() * head.joints.size())
    throw InputError(place, "names fewer quantities than the take has joints");
  all(t.laid_over, 0, "laid_over");
  all(t.sums, 1, "sums");
  all(t.ended, 0, "ended");
  all(t.histograms, 0, "histograms");
  std::uint64_t bins = 0;
  for (const HistogramRow& row : t.histograms) bins += row.bins;
  if (bins != t.bins.size() || std::ranges::any_of(t.bins, [](const BinRow& r) { return r.bin > kLastBin; }))
    throw InputError(place + "/bins", "are not those that the histograms have");
}

}  // namespace

void SampleBlock::reset(std::uint64_t first, std::uint64_t count, std::size_t joints, std::size_t methods) {
  first_instant = first;
  instants = count;
  time_ns.assign(count, 0);
  heading_rad.assign(count, std::numeric_limits<float>::quiet_NaN());
  truth_m.assign(count * joints * 3, kNaN);
  ranges.assign(count * joints, 0);
  occluded.assign(count * joints, 0);
  estimate_m.assign(count * joints * methods * 3, std::numeric_limits<float>::quiet_NaN());
  status.assign(count * joints * methods, 0);
  iterations.assign(count * joints * methods, 0);
  cost_m2.assign(count * joints * methods, std::numeric_limits<float>::quiet_NaN());
  gdop.assign(count * joints * methods, std::numeric_limits<float>::quiet_NaN());
  sigma_m.assign(count * joints * methods, std::numeric_limits<float>::quiet_NaN());
}

struct StoredTake::State {
  std::filesystem::path path;
  H5File file;
  TakeHead head;
  std::vector<SampleTables> tracks;
};

std::uint32_t bin_of(double length_m) {
  const double fine = length_m / kBin_m;
  if (fine < kFineBins) return static_cast<std::uint32_t>(fine);
  const double coarse = kFineBins + std::floor(std::log(fine / kFineBins) / std::log(kBinGrowth));
  return static_cast<std::uint32_t>(std::min<double>(kLastBin, coarse));
}

double bin_starts_at_m(std::uint32_t bin) {
  if (bin <= kFineBins) return bin * kBin_m;
  return kFineBins * kBin_m * std::pow(kBinGrowth, bin - kFineBins);
}

StoredTake::StoredTake() : state_(std::make_unique<State>()) {}
StoredTake::~StoredTake() = default;
StoredTake::StoredTake(StoredTake&&) noexcept = default;

StoredTake StoredTake::create(const std::filesystem::path& path, const TakeHead& head) {
  StoredTake take;
  State& s = *take.state_;
  s.path = path;
  s.head = head;
  s.file = H5File::create(path);
  s.file.set_text("format", kTakeFormat);
  s.file.set_integer("version", kTakeVersion);
  s.file.set_text("created_by", kProgramVersion);
  s.file.set_text("id", head.id);
  s.file.set_text("condition", head.condition);
  s.file.set_texts("joints", head.joints);
  s.file.set_texts("methods", head.methods);
  s.file.set_texts("status_names", head.status_names);
  s.file.set_texts("tracks", head.tracks);
  s.file.set_integer("is_upright", head.is_upright ? 1 : 0);
  H5Node samples = s.file.create_group("samples");
  for (std::size_t t = 0; t < head.tracks.size(); ++t) {
    H5Node track = samples.create_group(std::to_string(t));
    s.tracks.push_back(tables_of(
        head.joints.size(), head.methods.size(), [&](const char* name, H5Type type, const Shape& shape) {
          return track.create_table(name, type, shape, layout_of(name, shape, head), head.instants);
        }));
    for (std::size_t axis = 0; !head.track_position_m.empty() && axis < 3; ++axis)
      track.set_number(position_attribute(axis), head.track_position_m[t][axis]);
  }
  return take;
}

StoredTake StoredTake::open(const std::filesystem::path& path) {
  StoredTake take;
  State& s = *take.state_;
  s.path = path;
  s.file = H5File::open(path);
  if (!s.file.has_attribute("format") || s.file.text("format") != kTakeFormat)
    throw InputError(path.string(), "is not a file of a take's results");
  if (s.file.integer("version") != kTakeVersion)
    throw InputError(path.string(),
                     fmt::format("is another version; this program reads version {}", kTakeVersion));
  s.head.id = s.file.text("id");
  s.head.condition = s.file.text("condition");
  s.head.joints = s.file.texts("joints");
  s.head.methods = s.file.texts("methods");
  s.head.status_names = s.file.texts("status_names");
  if (s.head.joints.size() * s.head.methods.size() > kMaxEstimates)
    throw InputError(path.string(), fmt::format("has {} joints x {} methods, more than the {} allowed",
                                                s.head.joints.size(), s.head.methods.size(), kMaxEstimates));
  s.head.tracks = s.file.texts("tracks");
  s.head.is_upright = s.file.integer("is_upright") != 0;
  const H5Node samples = s.file.group("samples");
  if (s.head.tracks.empty() || s.head.tracks.size() > kMaxSensors)
    throw InputError(samples.place(), "must have 1 to 64 tracks");
  for (std::size_t t = 0; t < s.head.tracks.size(); ++t) {
    const H5Node track = samples.group(std::to_string(t));
    s.tracks.push_back(tables_of(
        s.head.joints.size(), s.head.methods.size(),
        [&](const char* name, H5Type type, const Shape& shape) { return track.table(name, type, shape); }));
    if (s.tracks[t].time_ns.rows() != s.tracks[0].time_ns.rows())
      throw InputError(track.place(), "is of another length than the first track");
    if (!track.has_attribute(position_attribute(0))) continue;
    s.head.track_position_m.resize(s.head.tracks.size());
    for (std::size_t axis = 0; axis < 3; ++axis)
      s.head.track_position_m[t][axis] = track.number(position_attribute(axis));
  }
  s.head.instants = s.tracks[0].time_ns.rows();
  return take;
}

void StoredTake::finish() {
  state_->tracks.clear();
  state_->file.close();
  sync_file(state_->path);
}

const std::filesystem::path& StoredTake::path() const { return state_->path; }
const TakeHead& StoredTake::head() const { return state_->head; }

void StoredTake::write(std::size_t track, const SampleBlock& b) {
  SampleTables& t = state_->tracks.at(track);
  const auto put = [&](H5Table& table, const auto& values) {
    table.write(b.first_instant, std::span(values.data(), values.size()));
  };
  put(t.time_ns, b.time_ns);
  put(t.heading_rad, b.heading_rad);
  put(t.truth_m, b.truth_m);
  put(t.ranges, b.ranges);
  put(t.occluded, b.occluded);
  put(t.estimate_m, b.estimate_m);
  put(t.status, b.status);
  put(t.iterations, b.iterations);
  put(t.cost_m2, b.cost_m2);
  put(t.gdop, b.gdop);
}

SampleBlock StoredTake::read(std::size_t track, std::uint64_t first_instant, std::uint64_t instants,
                             SampleColumns columns) const {
  SampleBlock block;
  read(track, first_instant, instants, columns, block);
  return block;
}

void StoredTake::read(std::size_t track, std::uint64_t first_instant, std::uint64_t instants,
                      SampleColumns columns, SampleBlock& b) const {
  const SampleTables& t = state_->tracks.at(track);
  const bool all = columns == SampleColumns::all;
  b.first_instant = first_instant;
  b.instants = instants;
  const auto get = [&](const H5Table& table, auto& values, bool wanted = true) {
    values.resize(wanted ? instants * table.row_elements() : 0);
    if (wanted) table.read(first_instant, std::span(values.data(), values.size()));
  };
  get(t.time_ns, b.time_ns);
  get(t.heading_rad, b.heading_rad);
  get(t.truth_m, b.truth_m);
  get(t.estimate_m, b.estimate_m);
  get(t.status, b.status);
  get(t.iterations, b.iterations);
  get(t.occluded, b.occluded);
  check_block(b, t, state_->head.status_names.size());
  get(t.ranges, b.ranges, all);
  get(t.cost_m2, b.cost_m2, all);
  get(t.gdop, b.gdop, all);
}

void StoredTake::write_errors(const TakeErrors& errors) {
  H5Node node = state_->file.create_group("errors");
  node.set_text("settings_sha256", errors.settings_sha256);
  node.set_texts("alignments", errors.alignments);
  node.set_texts("quantities", errors.quantities);
  node.set_texts("subsets", {kSubsetNames.begin(), kSubsetNames.end()});
  node.set_texts("measures", {kMeasureNames.begin(), kMeasureNames.end()});
  write_rows(node, "laid_over", errors.laid_over);
  write_rows(node, "sums", errors.sums);
  write_rows(node, "ended", errors.ended);
  write_rows(node, "histograms", errors.histograms);
  write_rows(node, "bins", errors.bins);
}

TakeErrors StoredTake::read_errors() const {
  const H5Node node = state_->file.group("errors");
  TakeErrors errors;
  errors.settings_sha256 = node.text("settings_sha256");
  errors.alignments = node.texts("alignments");
  errors.quantities = node.texts("quantities");
  errors.laid_over = read_rows<AlignmentRow>(node, "laid_over");
  errors.sums = read_rows<ErrorSums>(node, "sums");
  errors.ended = read_rows<EndedRow>(node, "ended");
  errors.histograms = read_rows<HistogramRow>(node, "histograms");
  errors.bins = read_rows<BinRow>(node, "bins");
  check_places(errors, state_->head, node.place());
  return errors;
}

}  // namespace trilat
