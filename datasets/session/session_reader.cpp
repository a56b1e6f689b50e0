// SPDX-License-Identifier: MIT
#include "datasets/session/session_reader.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <limits>
#include <optional>

#include "datasets/base/error.h"
#include "datasets/session/session_layout.h"
#include "datasets/session/session_tables.h"

namespace trilat {
namespace {

namespace layout = session_layout;

constexpr std::int64_t kMaxHeaderNs = std::int64_t{1} << 61;  // so that sums of two times cannot overflow

DepthIntrinsics read_intrinsics(const H5Node& node) {
  DepthIntrinsics in;
  const auto pixels = [&](const char* name) {
    return static_cast<int>(std::clamp<std::int64_t>(node.integer(name), 0, 1 << 20));
  };
  in.width_px = pixels("width_px");
  in.height_px = pixels("height_px");
  in.fx_px = node.number("fx_px");
  in.fy_px = node.number("fy_px");
  in.cx_px = node.number("cx_px");
  in.cy_px = node.number("cy_px");
  in.k1 = node.number("k1");
  in.k2 = node.number("k2");
  in.k3 = node.number("k3");
  in.p1 = node.number("p1");
  in.p2 = node.number("p2");
  if (const std::string why = problem_with(in); !why.empty())
    throw InputError(node.place(), "has intrinsics that cannot be: it " + why);
  return in;
}

SensorDescription read_description(const H5Node& node, const std::string& name) {
  SensorDescription sensor;
  sensor.name = name;
  sensor.serial = node.text("serial");
  sensor.model = node.text("model");
  sensor.source = node.text("source");
  sensor.tick_ns = node.integer("tick_ns");
  sensor.nominal_rate_hz = node.number("nominal_rate_hz");
  sensor.latency_ns = node.integer("latency_ns");
  if (sensor.tick_ns < 1 || sensor.tick_ns > 1'000'000'000)
    throw InputError(node.place() + "@tick_ns", "must lie between 1 and 1000000000");
  if (!(sensor.nominal_rate_hz > 0.1 && sensor.nominal_rate_hz < 10'000.0))
    throw InputError(node.place() + "@nominal_rate_hz", "must lie between 0.1 and 10000");
  sensor.intrinsics = read_intrinsics(node);
  sensor.has_depth = node.has("depth");
  return sensor;
}

void check_range(const std::string& place, std::uint64_t first, std::uint64_t count, std::uint64_t rows) {
  if (first > rows || count > rows - first)
    throw InputError(place, "has " + std::to_string(rows) + " whole rows; rows " + std::to_string(first) +
                                " to " + std::to_string(first + count) + " were asked for");
}

void read_bodies(const layout::Bodies<ReadColumn>& columns, std::uint64_t first, std::span<Body> bodies) {
  const std::uint64_t n = bodies.size();
  const auto ids = columns.tracking_id.read(first, n);
  const auto positions = columns.position_m.read(first, n);
  const auto orientations = columns.orientation.read(first, n);
  const auto states = columns.tracking_state.read(first, n);
  const auto hands = columns.hand_state.read(first, n);
  const auto confidences = columns.hand_confidence.read(first, n);
  for (std::size_t b = 0; b < n; ++b) {
    Body& body = bodies[b];
    body.tracking_id = ids[b];
    std::copy_n(&positions[b * kJointCount * 3], kJointCount * 3, body.position_m[0].data());
    std::copy_n(&orientations[b * kJointCount * 4], kJointCount * 4, body.orientation_xyzw[0].data());
    std::copy_n(&states[b * kJointCount], kJointCount, body.tracking_state.data());
    std::copy_n(&hands[b * 2], 2, body.hand_state.data());
    std::copy_n(&confidences[b * 2], 2, body.hand_confidence.data());
  }
}

}  // namespace

struct SessionReader::State {
  std::filesystem::path path;
  H5File file;
  SessionHeader header;
  std::string created_by;
  bool complete = false;
  std::vector<SensorTables> sensors;
};

SessionReader::SessionReader(const std::filesystem::path& path) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.path = path;
  s.file = H5File::open(path);
  if (!s.file.has_attribute("format") || s.file.text("format") != layout::kFormat)
    throw InputError(path.string(), "is an HDF5 file, but not a session of this program");
  if (const auto version = s.file.integer("version"); version != layout::kVersion)
    throw InputError(path.string(), "is a session of format version " + std::to_string(version) +
                                        "; this program reads version " + std::to_string(layout::kVersion));
  s.created_by = s.file.text("created_by");
  s.complete = s.file.integer("complete") == 1 && !s.file.unfinished();
  s.header.simulated = s.file.integer("simulated") != 0;
  s.header.started_utc = s.file.text("started_utc");
  s.header.note = s.file.text("note");
  const H5Node sensors = s.file.group("sensors");
  for (const std::string& name : sensors.children(kMaxSessionSensors)) {
    if (printable(name) != name || name.find_first_of("\n\t") != std::string::npos)
      throw InputError(sensors.place(),
                       "holds a sensor with control characters in its name, which no recorder writes");
    const H5Node node = sensors.group(name);
    s.header.sensors.push_back(read_description(node, name));
    s.sensors.push_back(open_sensor_tables(node, s.complete));
  }
  if (s.sensors.empty()) throw InputError(sensors.place(), "holds no sensor");
}

SessionReader::~SessionReader() = default;
SessionReader::SessionReader(SessionReader&&) noexcept = default;

const std::filesystem::path& SessionReader::path() const { return state_->path; }
const SessionHeader& SessionReader::header() const { return state_->header; }
const std::string& SessionReader::created_by() const { return state_->created_by; }
bool SessionReader::complete() const { return state_->complete; }
const SensorCounts& SessionReader::counts(std::size_t sensor) const {
  return state_->sensors.at(sensor).counts;
}

std::uint64_t SessionReader::depth_stored_bytes(std::size_t sensor) const {
  const SensorTables& t = state_->sensors.at(sensor);
  return t.depth_frames ? t.depth_frames->stored_bytes() : 0;
}

std::size_t SessionReader::sensor_index(const std::string& name) const {
  std::string known;
  for (std::size_t i = 0; i < state_->header.sensors.size(); ++i) {
    if (state_->header.sensors[i].name == name) return i;
    known += (known.empty() ? "" : ", ") + state_->header.sensors[i].name;
  }
  throw InputError(state_->path.string(), "has no sensor \"" + name + "\"; it has " + known);
}

std::vector<FrameStamp> SessionReader::stamps(std::size_t sensor, FrameStream stream, std::uint64_t first,
                                              std::uint64_t count) const {
  const SensorTables& t = state_->sensors.at(sensor);
  if (stream == FrameStream::depth && !t.depth_stamps)
    throw InputError(t.frames.body_count.place(), "belongs to a sensor without depth");
  const layout::Stamps<ReadColumn>& columns =
      stream == FrameStream::depth ? *t.depth_stamps : t.frames.stamps;
  check_range(columns.sequence.place(), first, count,
              stream == FrameStream::depth ? t.counts.depth_frames : t.counts.body_frames);
  const auto sequence = columns.sequence.read(first, count);
  const auto ticks = columns.device_ticks.read(first, count);
  const auto arrival = columns.arrival_ns.read(first, count);
  std::vector<FrameStamp> result(count);
  const std::int64_t most_ticks = kMaxHeaderNs / state_->header.sensors[sensor].tick_ns;
  for (std::size_t i = 0; i < count; ++i) {
    if (std::abs(ticks[i] / 2) > most_ticks / 2 || std::abs(arrival[i] / 2) > kMaxHeaderNs / 2)
      throw InputError(
          columns.device_ticks.place(),
          "row " + std::to_string(first + i) + " holds a time beyond 73 years, which no clock shows");
    result[i] = {sequence[i], ticks[i], arrival[i]};
  }
  return result;
}

std::vector<BodyFrame> SessionReader::body_frames(std::size_t sensor, std::uint64_t first,
                                                  std::uint64_t count) const {
  const SensorTables& t = state_->sensors.at(sensor);
  check_range(t.frames.body_count.place(), first, count, t.counts.body_frames);
  std::vector<BodyFrame> frames(count);
  if (count == 0) return frames;
  const auto stamps_of = stamps(sensor, FrameStream::bodies, first, count);
  const auto floors = t.frames.floor_plane.read(first, count);
  const std::uint64_t checkpoint = first / kBodyCheckpoint * kBodyCheckpoint;
  const auto counts = t.frames.body_count.read(checkpoint, first + count - checkpoint);
  std::uint64_t row = t.body_row_at[checkpoint / kBodyCheckpoint], total = 0;
  for (std::uint64_t i = 0; i < counts.size(); ++i) (i < first - checkpoint ? row : total) += counts[i];
  std::vector<Body> bodies(total);
  read_bodies(t.bodies, row, bodies);
  const std::vector<std::uint64_t> frame_of = t.bodies.frame.read(row, total);
  auto next = bodies.begin();
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t b = 0; b < counts[first - checkpoint + i]; ++b) {
      const auto place = static_cast<std::size_t>(next - bodies.begin()) + b;
      if (frame_of[place] != first + i)
        throw InputError(t.bodies.frame.place(), "row " + std::to_string(row + place) + " is of frame " +
                                                     std::to_string(frame_of[place]) +
                                                     ", and by the sum of body_count of frame " +
                                                     std::to_string(first + i) + ": one of both is damaged");
    }
    frames[i].stamp = stamps_of[i];
    std::copy_n(&floors[4 * i], 4, frames[i].floor_plane.data());
    const auto end = next + counts[first - checkpoint + i];
    frames[i].bodies.assign(next, end);
    next = end;
  }
  return frames;
}

void SessionReader::depth_frame(std::size_t sensor, std::uint64_t index,
                                std::span<std::uint16_t> depth_mm) const {
  const SensorTables& t = state_->sensors.at(sensor);
  if (!t.depth_frames) throw InputError(t.frames.body_count.place(), "belongs to a sensor without depth");
  check_range(t.depth_frames->place(), index, 1, t.counts.depth_frames);
  t.depth_frames->read(index, depth_mm);
}

StoredDepthFrame SessionReader::stored_depth_frame(std::size_t sensor, std::uint64_t index) const {
  const SensorTables& t = state_->sensors.at(sensor);
  if (!t.depth_frames) throw InputError(t.frames.body_count.place(), "belongs to a sensor without depth");
  check_range(t.depth_frames->place(), index, 1, t.counts.depth_frames);
  StoredDepthFrame frame{
      t.depth_frames->place() + " frame " + std::to_string(index), t.counts.depth_compression, {}};
  if (frame.compression) {
    frame.chunk = t.depth_frames->read_filtered_row(index);
  } else {
    frame.chunk.resize(kDepthPixels * sizeof(std::uint16_t));
    depth_frame(sensor, index, {reinterpret_cast<std::uint16_t*>(frame.chunk.data()), kDepthPixels});
  }
  return frame;
}

void decode_depth_frame(const StoredDepthFrame& frame, std::span<std::uint16_t> depth_mm) {
  static_assert(std::endian::native == std::endian::little, "the file's words are little-endian");
  TRILAT_CHECK(depth_mm.size() == kDepthPixels, "the image has room for a depth frame");
  const std::span<std::byte> raw = std::as_writable_bytes(depth_mm);
  if (!frame.compression) {
    TRILAT_CHECK(frame.chunk.size() == raw.size(), "an uncompressed frame is whole");
    std::copy(frame.chunk.begin(), frame.chunk.end(), raw.begin());
  } else if (!decode_chunk(frame.chunk, *frame.compression, raw)) {
    throw InputError(frame.place, "cannot be read: the stored data are damaged");
  }
}

std::vector<ClockExchange> SessionReader::clock_exchanges(std::size_t sensor) const {
  return clock_exchanges(sensor, 0, state_->sensors.at(sensor).counts.clock_exchanges);
}

std::vector<ClockExchange> SessionReader::clock_exchanges(std::size_t sensor, std::uint64_t first,
                                                          std::uint64_t count) const {
  const SensorTables& t = state_->sensors.at(sensor);
  check_range(t.lists.clock_exchanges.place(), first, count, t.counts.clock_exchanges);
  const auto values = t.lists.clock_exchanges.read(first, count);
  std::vector<ClockExchange> result(count);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = {values[4 * i], values[4 * i + 1], values[4 * i + 2], values[4 * i + 3]};
    for (std::size_t k = 0; k < 4; ++k)
      if (std::abs(values[4 * i + k] / 2) > kMaxHeaderNs / 4)
        throw InputError(t.lists.clock_exchanges.place(),
                         "row " + std::to_string(first + i) + " holds an impossible time");
  }
  return result;
}

std::vector<DropCount> SessionReader::drop_counts(std::size_t sensor) const {
  const SensorTables& t = state_->sensors.at(sensor);
  const std::uint64_t rows = t.counts.drop_counts;
  const auto values = t.lists.drop_counts.read(0, rows);
  std::vector<DropCount> result(rows);
  for (std::size_t i = 0; i < rows; ++i) result[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
  return result;
}

std::vector<SensorNotice> SessionReader::notices(std::size_t sensor) const {
  const SensorTables& t = state_->sensors.at(sensor);
  std::vector<SensorNotice> result(t.counts.notices);
  if (result.empty()) return result;
  const auto times = t.notices.host_ns.read(0, result.size());
  const auto texts = t.notices.text.read(0, result.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto begin = texts.begin() + static_cast<std::ptrdiff_t>(i * layout::kNoticeBytes);
    const auto end = begin + static_cast<std::ptrdiff_t>(layout::kNoticeBytes);
    result[i] = {times[i], std::string(begin, std::find(begin, end, 0))};
  }
  return result;
}

}  // namespace trilat
