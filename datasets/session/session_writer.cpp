// SPDX-License-Identifier: MIT
#include "datasets/session/session_writer.h"

#include <array>
#include <iterator>
#include <mutex>
#include <optional>
#include <set>
#include <system_error>
#include <vector>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "datasets/hdf5/hdf5_file.h"
#include "datasets/session/session_layout.h"
#include "datasets/session/session_reader.h"

namespace trilat {
namespace {

namespace layout = session_layout;

constexpr std::size_t kRowsPerChunk = 256;
constexpr std::uint64_t kRowsAtOnce = 16 * kRowsPerChunk;  // gathered before they are written

// A column of one table that gathers rows and writes many at once.
template <class T>
struct WriteColumn {
  H5Table table;
  std::vector<T> rows;

  void create(H5Node& node, const char* name, const std::vector<std::uint64_t>& row_shape) {
    table =
        node.create_table(name, h5_type_of<T>(), row_shape, {.chunk_rows = kRowsPerChunk, .checksum = true});
  }
  template <class Values>
  void add(const Values& values) {
    rows.insert(rows.end(), std::begin(values), std::end(values));
  }
  void write() {
    table.append(std::span<const T>(rows));
    rows.clear();
  }
};

template <class Tables>
void create_columns(Tables& tables, auto&& node) {
  Tables::columns(tables, [&](const char* name, auto& column, auto... extents) {
    column.create(node, name, {static_cast<std::uint64_t>(extents)...});
  });
}

template <class Tables>
void write_columns(Tables& tables) {
  Tables::columns(tables, [](const char*, auto& column, auto...) { column.write(); });
}

void add_stamp(layout::Stamps<WriteColumn>& stamps, const FrameStamp& stamp) {
  stamps.sequence.rows.push_back(stamp.sequence);
  stamps.device_ticks.rows.push_back(stamp.device_ticks);
  stamps.arrival_ns.rows.push_back(stamp.arrival_ns);
}

void add_body(layout::Bodies<WriteColumn>& bodies, std::uint64_t frame, const Body& body) {
  bodies.frame.rows.push_back(frame);
  bodies.tracking_id.rows.push_back(body.tracking_id);
  for (const auto& point : body.position_m) bodies.position_m.add(point);
  for (const auto& turn : body.orientation_xyzw) bodies.orientation.add(turn);
  bodies.tracking_state.add(body.tracking_state);
  bodies.hand_state.add(body.hand_state);
  bodies.hand_confidence.add(body.hand_confidence);
}

struct DepthTables {
  H5Table frames;
  layout::Stamps<WriteColumn> stamps;
};

struct WrittenTables {
  layout::BodyFrames<WriteColumn> frames;
  layout::Bodies<WriteColumn> bodies;
  std::optional<DepthTables> depth;
  layout::Lists<WriteColumn> lists;
  layout::Notices<WriteColumn> notices;
  std::uint64_t body_frames = 0, stored_notices = 0;

  void write() {
    write_columns(bodies);
    write_columns(frames);
    if (depth) write_columns(depth->stamps);
    write_columns(lists);
    write_columns(notices);
  }
};

void describe(H5Node& node, const SensorDescription& sensor) {
  node.set_text("serial", sensor.serial);
  node.set_text("model", sensor.model);
  node.set_text("source", sensor.source);
  node.set_integer("tick_ns", sensor.tick_ns);
  node.set_number("nominal_rate_hz", sensor.nominal_rate_hz);
  node.set_integer("latency_ns", sensor.latency_ns);
  const DepthIntrinsics& in = sensor.intrinsics;
  node.set_integer("width_px", in.width_px);
  node.set_integer("height_px", in.height_px);
  const std::pair<const char*, double> numbers[] = {
      {"fx_px", in.fx_px}, {"fy_px", in.fy_px}, {"cx_px", in.cx_px}, {"cy_px", in.cy_px}, {"k1", in.k1},
      {"k2", in.k2},       {"k3", in.k3},       {"p1", in.p1},       {"p2", in.p2}};
  for (const auto& [name, value] : numbers) node.set_number(name, value);
}

DepthTables depth_tables(H5Node node, ChunkCompression compression) {
  const H5Layout stored{.chunk_rows = 1, .checksum = true, .compression = compression};
  DepthTables tables{
      node.create_table(layout::kDepthFrames, H5Type::u16, {kDepthHeight, kDepthWidth}, stored), {}};
  create_columns(tables.stamps, node);
  return tables;
}

}  // namespace

void check_session_header(const SessionHeader& header, const std::string& place) {
  std::set<std::string> names;
  for (const SensorDescription& sensor : header.sensors) {
    if (sensor.name.empty() || sensor.name.find('/') != std::string::npos || sensor.name.size() > 64)
      throw InputError(place,
                       "a sensor's name must have 1 to 64 characters and no '/', is \"" + sensor.name + '"');
    if (!names.insert(sensor.name).second)
      throw InputError(place, "has two sensors named \"" + sensor.name + '"');
  }
  if (names.empty() || names.size() > kMaxSessionSensors)
    throw InputError(place, "a session has 1 to " + std::to_string(kMaxSessionSensors) + " sensors");
}

struct SessionWriter::State {
  std::filesystem::path path;
  H5File file;
  ChunkCompression depth_compression;
  std::vector<WrittenTables> sensors;
};

SessionWriter::SessionWriter(const std::filesystem::path& path, const SessionHeader& header,
                             ChunkCompression depth_compression)
    : state_(std::make_unique<State>()) {
  check_session_header(header, path.string());
  state_->path = path;
  state_->depth_compression = depth_compression;
  state_->file = H5File::create(partial_name(path));
  H5File& file = state_->file;
  file.set_text("format", layout::kFormat);
  file.set_integer("version", layout::kVersion);
  // Equal simulations are equal bytes, whatever the version.
  file.set_text("created_by", header.simulated ? "trilat" : kProgramVersion);
  file.set_integer("simulated", header.simulated);
  file.set_integer("complete", 0);
  file.set_text("started_utc", header.started_utc);
  file.set_text("note", header.note);
  H5Node sensors = file.create_group("sensors");
  for (const SensorDescription& sensor : header.sensors) {
    H5Node node = sensors.create_group(sensor.name);
    describe(node, sensor);
    WrittenTables& tables = state_->sensors.emplace_back();
    create_columns(tables.frames, node.create_group("body_frames"));
    create_columns(tables.bodies, node.create_group("bodies"));
    if (sensor.has_depth) tables.depth = depth_tables(node.create_group("depth"), depth_compression);
    create_columns(tables.lists, node);
    create_columns(tables.notices, node.create_group("notices"));
  }
}

SessionWriter::~SessionWriter() {
  if (!state_) return;
  const std::filesystem::path unfinished = partial_name(state_->path);
  state_.reset();
  std::error_code ignored;
  std::filesystem::remove(unfinished, ignored);
}

// A library that can neither write nor close in peace must not be asked to: the file is cut off, and its
// handles are kept for ever.
template <class Work>
void SessionWriter::guarded(const Work& work) {
  static std::vector<std::unique_ptr<State>>* abandoned = new std::vector<std::unique_ptr<State>>;
  TRILAT_CHECK(state_, "nothing is written after an error");
  try {
    work();
  } catch (const InputError&) {
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    state_->file.detach_after_write_error();
    std::error_code ignored;
    std::filesystem::remove(partial_name(state_->path), ignored);
    abandoned->push_back(std::move(state_));
    throw;
  }
}

void SessionWriter::add_body_frame(std::size_t sensor, const BodyFrame& frame) {
  TRILAT_CHECK(sensor < state_->sensors.size() && frame.bodies.size() <= kMaxBodies,
               "a body frame belongs to a sensor and has at most six bodies");
  WrittenTables& tables = state_->sensors[sensor];
  for (const Body& body : frame.bodies) add_body(tables.bodies, tables.body_frames, body);
  add_stamp(tables.frames.stamps, frame.stamp);
  tables.frames.floor_plane.add(frame.floor_plane);
  tables.frames.body_count.rows.push_back(static_cast<std::uint8_t>(frame.bodies.size()));
  if (++tables.body_frames % kRowsAtOnce == 0) guarded([&] { tables.write(); });
}

void SessionWriter::add_depth_frame(std::size_t sensor, const EncodedDepthFrame& frame) {
  TRILAT_CHECK(sensor < state_->sensors.size() && state_->sensors[sensor].depth,
               "a depth frame belongs to a sensor that has depth");
  if (frame.compression != state_->depth_compression) {
    std::vector<std::uint16_t> depth_mm(kDepthPixels);
    decode_depth_frame({"a depth frame", frame.compression, frame.chunk}, depth_mm);
    return add_depth_frame(sensor, encode_depth_frame(frame.stamp, depth_mm, state_->depth_compression));
  }
  DepthTables& depth = *state_->sensors[sensor].depth;
  add_stamp(depth.stamps, frame.stamp);
  guarded([&] {
    depth.frames.append_filtered_row(frame.chunk);
    if (depth.stamps.sequence.rows.size() >= kRowsAtOnce) write_columns(depth.stamps);
  });
}

void SessionWriter::add_clock_exchange(std::size_t sensor, const ClockExchange& e) {
  state_->sensors.at(sensor).lists.clock_exchanges.add(std::array{e.t1_ns, e.t2_ns, e.t3_ns, e.t4_ns});
}

void SessionWriter::add_drop_count(std::size_t sensor, const DropCount& count) {
  state_->sensors.at(sensor).lists.drop_counts.add(
      std::array{count.host_ns, count.at_source, count.in_queue});
}

void SessionWriter::add_notice(std::size_t sensor, const SensorNotice& notice) {
  WrittenTables& tables = state_->sensors.at(sensor);
  if (tables.stored_notices >= kMaxSessionNotices) return;
  const bool is_last = ++tables.stored_notices == kMaxSessionNotices;
  const std::string_view shown =
      is_last ? "there were too many notices; no more are stored" : std::string_view(notice.text);
  std::vector<std::uint8_t> text(shown.begin(), shown.end());
  text.resize(layout::kNoticeBytes, 0);
  tables.notices.host_ns.rows.push_back(notice.host_ns);
  tables.notices.text.add(text);
}

void SessionWriter::finish() {
  guarded([&] {
    for (WrittenTables& sensor : state_->sensors) sensor.write();
    state_->file.set_integer("complete", 1);
    state_->sensors.clear();
    state_->file.close();
  });
  const std::filesystem::path path = state_->path;
  state_.reset();
  publish_file(partial_name(path), path);
}

}  // namespace trilat
