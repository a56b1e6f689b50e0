// SPDX-License-Identifier: MIT
#include "datasets/session/session_tables.h"

#include <algorithm>
#include <array>
#include <limits>

#include "datasets/base/error.h"
#include "datasets/session/session_layout.h"

namespace trilat {
namespace {

namespace layout = session_layout;

H5Table open_column(const H5Node& node, const layout::Column& column) {
  return node.table(column.name, column.type, column.row_shape);
}

// What readers hold in memory at once is bounded by these: 6 days of frames at 30 Hz, 12 of exchanges at 4
// Hz.
constexpr std::uint64_t kMostFrames = std::uint64_t{1} << 24;
constexpr std::uint64_t kMostExchanges = std::uint64_t{1} << 22;
constexpr std::uint64_t kMostDropCounts = std::uint64_t{1} << 20;
constexpr std::uint64_t kMostNotices = std::uint64_t{1} << 16;

void check_rows(const H5Table& table, std::uint64_t most) {
  if (table.rows() > most)
    throw InputError(table.place(), "has " + std::to_string(table.rows()) + " rows; a session has at most " +
                                        std::to_string(most));
}

void check_rows(const SensorTables& t) {
  check_rows(t.body_count, kMostFrames);
  if (t.depth_frames) check_rows(*t.depth_frames, kMostFrames);
  check_rows(t.clock_exchanges, kMostExchanges);
  check_rows(t.drop_counts, kMostDropCounts);
  check_rows(t.notice_text, kMostNotices);
}

// The rows that all tables have, and how many some have beyond.
struct CommonRows {
  std::uint64_t rows = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t most = 0;
  CommonRows& with(const H5Table& table) {
    const std::uint64_t count = table.rows();
    rows = std::min(rows, count);
    most = std::max(most, count);
    return *this;
  }
};

// What the writer said to have flushed, in the order of layout::kFlushed; without its word, no limit. Of the
// last two rows the larger numbers: the last may be half written, and every number in it was true.
std::array<std::uint64_t, 6> flushed_rows(const H5Node& node, bool complete) {
  std::array<std::uint64_t, 6> limits;
  limits.fill(std::numeric_limits<std::uint64_t>::max());
  if (complete || !node.has(layout::kFlushed.name)) return limits;
  limits.fill(0);
  H5Table table = open_column(node, layout::kFlushed);
  table.accept_torn_end();
  const std::uint64_t rows = table.rows(), count = std::min<std::uint64_t>(rows, 2);
  std::vector<std::int64_t> values(count * limits.size());
  table.read(rows - count, std::span(values));
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::uint64_t& limit = limits[i % limits.size()];
    limit = std::max(limit, static_cast<std::uint64_t>(std::max<std::int64_t>(values[i], 0)));
  }
  return limits;
}

// Reads counts up to the first that cannot be read, and says how many there are before it.
std::uint64_t read_until_damaged(const H5Table& table, std::uint64_t first, std::span<std::uint8_t> counts) {
  for (std::uint64_t i = 0; i < counts.size(); ++i) try {
      table.read(first + i, counts.subspan(i, 1));
    } catch (const InputError&) {
      return i;
    }
  return counts.size();
}

// Follows the body counts through all frames: how many frames have all their bodies, and where
// bodies start. Without `complete`, counts that cannot be read are the end.
void index_bodies(SensorTables& t, std::uint64_t frames, std::uint64_t body_rows, bool complete) {
  std::vector<std::uint8_t> block(kBodyCheckpoint);
  std::uint64_t row = 0, frame = 0;
  while (frame < frames) {
    std::uint64_t count = std::min(kBodyCheckpoint, frames - frame);
    try {
      t.body_count.read(frame, std::span(block).first(count));
    } catch (const InputError&) {
      if (complete) throw;
      count = read_until_damaged(t.body_count, frame, std::span(block).first(count));
      t.counts.unreadable_body_frames = frames - frame - count;
      frames = frame + count;
    }
    t.body_row_at.push_back(row);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (block[i] > kMaxBodies)
        throw InputError(t.body_count.place(), "row " + std::to_string(frame + i) + " claims " +
                                                   std::to_string(block[i]) +
                                                   " bodies; a frame has at most 6");
      if (row + block[i] > body_rows) {
        t.counts.body_frames = frame + i;
        t.counts.bodies = row;
        return;
      }
      row += block[i];
    }
    frame += count;
  }
  t.counts.body_frames = frame;
  t.counts.bodies = row;
}

std::vector<H5Table*> body_tables(SensorTables& t) {
  BodyColumns& b = t.bodies;
  return {&b.frame,          &b.tracking_id, &b.position_m,     &b.orientation,
          &b.tracking_state, &b.hand_state,  &b.hand_confidence};
}

std::vector<H5Table*> body_frame_tables(SensorTables& t) {
  return {&t.body_stamps.sequence, &t.body_stamps.device_ticks, &t.body_stamps.arrival_ns, &t.floor_plane,
          &t.body_count};
}

CommonRows common_rows(const std::vector<H5Table*>& tables) {
  CommonRows rows;
  for (const H5Table* table : tables) rows.with(*table);
  return rows;
}

void accept_torn_ends(SensorTables& t) {
  std::vector<H5Table*> all = body_tables(t);
  for (H5Table* table : body_frame_tables(t)) all.push_back(table);
  if (t.depth_stamps)
    for (H5Table* table :
         {&t.depth_stamps->sequence, &t.depth_stamps->device_ticks, &t.depth_stamps->arrival_ns})
      all.push_back(table);
  all.insert(all.end(), {&t.clock_exchanges, &t.drop_counts, &t.notice_host_ns, &t.notice_text});
  for (H5Table* table : all) table->accept_torn_end();
}

void count_depth(SensorTables& t, std::uint64_t limit) {
  CommonRows rows = CommonRows{}
                        .with(t.depth_stamps->sequence)
                        .with(t.depth_stamps->device_ticks)
                        .with(t.depth_stamps->arrival_ns)
                        .with(*t.depth_frames);
  t.counts.depth_compression = t.depth_frames->row_compression();
  std::uint64_t count = std::min(rows.rows, limit);
  // only a killed writer's file ends with frames that were announced and not written
  if (t.counts.depth_compression)
    while (count > 0 && !t.depth_frames->has_filtered_row(count - 1)) --count;
  t.counts.depth_frames = count;
  t.counts.torn_rows += rows.most - count;
}

SensorTables open_all(const H5Node& node) {
  const H5Node frames = node.group("body_frames"), notices = node.group("notices");
  SensorTables t{StampColumns(frames),
                 open_column(frames, layout::kBodyFrameColumns[3]),
                 open_column(frames, layout::kBodyFrameColumns[4]),
                 BodyColumns(node.group("bodies")),
                 {},
                 {},
                 open_column(node, layout::kClockExchanges),
                 open_column(node, layout::kDropCounts),
                 open_column(notices, layout::kNoticeColumns[0]),
                 open_column(notices, layout::kNoticeColumns[1]),
                 {},
                 {}};
  if (node.has("depth")) {
    const H5Node depth = node.group("depth");
    t.depth_stamps.emplace(depth);
    t.depth_frames.emplace(open_column(depth, layout::kDepthFrames));
  }
  return t;
}

}  // namespace

StampColumns::StampColumns(const H5Node& node)
    : sequence(open_column(node, layout::kDepthStampColumns[0])),
      device_ticks(open_column(node, layout::kDepthStampColumns[1])),
      arrival_ns(open_column(node, layout::kDepthStampColumns[2])) {}

BodyColumns::BodyColumns(const H5Node& node)
    : frame(open_column(node, layout::kBodyColumns[0])),
      tracking_id(open_column(node, layout::kBodyColumns[1])),
      position_m(open_column(node, layout::kBodyColumns[2])),
      orientation(open_column(node, layout::kBodyColumns[3])),
      tracking_state(open_column(node, layout::kBodyColumns[4])),
      hand_state(open_column(node, layout::kBodyColumns[5])),
      hand_confidence(open_column(node, layout::kBodyColumns[6])) {}

SensorTables open_sensor_tables(const H5Node& sensor, bool complete) {
  SensorTables t = open_all(sensor);
  check_rows(t);
  if (!complete) accept_torn_ends(t);
  const auto limits = flushed_rows(sensor, complete);
  const CommonRows frame_rows = common_rows(body_frame_tables(t));
  const CommonRows body_rows = common_rows(body_tables(t));
  index_bodies(t, std::min(frame_rows.rows, limits[0]), std::min(body_rows.rows, limits[1]), complete);
  t.counts.torn_rows = frame_rows.most - t.counts.body_frames + body_rows.most - t.counts.bodies;
  if (t.depth_frames) count_depth(t, limits[2]);
  t.counts.clock_exchanges = std::min(t.clock_exchanges.rows(), limits[3]);
  t.counts.drop_counts = std::min(t.drop_counts.rows(), limits[4]);
  t.counts.notices = std::min({t.notice_host_ns.rows(), t.notice_text.rows(), limits[5]});
  return t;
}

}  // namespace trilat
