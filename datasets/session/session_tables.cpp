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

template <class Tables>
void open_columns(Tables& tables, const H5Node& node) {
  Tables::columns(tables, [&](const char* name, auto& column, auto... extents) {
    column.open(node, name, {static_cast<std::uint64_t>(extents)...});
  });
}

// Bounds of what readers hold in memory at once: 6 days of frames at 30 Hz, 12 of exchanges at 4
// Hz.
constexpr std::uint64_t kMaxFrames = std::uint64_t{1} << 24;
constexpr std::uint64_t kMaxExchanges = std::uint64_t{1} << 22;
constexpr std::uint64_t kMaxDropCounts = std::uint64_t{1} << 20;

void check_rows(const H5Table& table, std::uint64_t most) {
  if (table.rows() > most)
    throw InputError(table.place(), "has " + std::to_string(table.rows()) + " rows; a session has at most " +
                                        std::to_string(most));
}

void check_rows(const SensorTables& t) {
  check_rows(t.frames.body_count.table, kMaxFrames);
  if (t.depth_frames) check_rows(*t.depth_frames, kMaxFrames);
  check_rows(t.lists.clock_exchanges.table, kMaxExchanges);
  check_rows(t.lists.drop_counts.table, kMaxDropCounts);
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

// Numbers of rows that the writer flushed, in the order of layout::kFlushed; without them no limit. Of the
// last two rows the larger numbers: the last may be half written, and every number in it was true.
std::array<std::uint64_t, layout::kFlushedNumbers> flushed_rows(const H5Node& node, bool complete) {
  std::array<std::uint64_t, layout::kFlushedNumbers> limits;
  limits.fill(std::numeric_limits<std::uint64_t>::max());
  if (complete || !node.has(layout::kFlushed)) return limits;
  limits.fill(0);
  ReadColumn<std::int64_t> flushed;
  flushed.open(node, layout::kFlushed, {layout::kFlushedNumbers});
  flushed.table.ignore_last_checksum();
  const std::uint64_t rows = flushed.table.rows(), count = std::min<std::uint64_t>(rows, 2);
  const std::vector<std::int64_t> values = flushed.read(rows - count, count);
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

// Follows the body counts through all frames: how many frames have all their bodies, and where bodies start.
// Without `complete`, counts that cannot be read are the end.
void index_bodies(SensorTables& t, std::uint64_t frames, std::uint64_t body_rows, bool complete) {
  const H5Table& body_count = t.frames.body_count.table;
  std::vector<std::uint8_t> block(kBodyCheckpoint);
  std::uint64_t row = 0, frame = 0;
  while (frame < frames) {
    std::uint64_t count = std::min(kBodyCheckpoint, frames - frame);
    try {
      body_count.read(frame, std::span(block).first(count));
    } catch (const InputError&) {
      if (complete) throw;
      count = read_until_damaged(body_count, frame, std::span(block).first(count));
      t.counts.unreadable_body_frames = frames - frame - count;
      frames = frame + count;
    }
    t.body_row_at.push_back(row);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (block[i] > kMaxBodies)
        throw InputError(body_count.place(), "row " + std::to_string(frame + i) + " claims " +
                                                 std::to_string(block[i]) + " bodies; a frame has at most 6");
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

template <class Tables>
CommonRows common_rows(const Tables& tables) {
  CommonRows rows;
  Tables::columns(tables, [&](const char*, const auto& column, auto...) { rows.with(column.table); });
  return rows;
}

void accept_torn_ends(SensorTables& t) {
  const auto accept = [](const char*, auto& column, auto...) { column.table.ignore_last_checksum(); };
  layout::BodyFrames<ReadColumn>::columns(t.frames, accept);
  layout::Bodies<ReadColumn>::columns(t.bodies, accept);
  if (t.depth_stamps) layout::Stamps<ReadColumn>::columns(*t.depth_stamps, accept);
  layout::Lists<ReadColumn>::columns(t.lists, accept);
  layout::Notices<ReadColumn>::columns(t.notices, accept);
}

void count_depth(SensorTables& t, std::uint64_t limit) {
  const CommonRows rows = common_rows(*t.depth_stamps).with(*t.depth_frames);
  t.counts.depth_compression = t.depth_frames->row_compression();
  std::uint64_t count = std::min(rows.rows, limit);
  // only a killed writer's file ends with frames that were announced and not written
  if (t.counts.depth_compression)
    while (count > 0 && !t.depth_frames->has_filtered_row(count - 1)) --count;
  t.counts.depth_frames = count;
  t.counts.torn_rows += rows.most - count;
}

SensorTables open_all(const H5Node& node) {
  SensorTables t;
  open_columns(t.frames, node.group("body_frames"));
  open_columns(t.bodies, node.group("bodies"));
  open_columns(t.lists, node);
  open_columns(t.notices, node.group("notices"));
  if (node.has("depth")) {
    const H5Node depth = node.group("depth");
    open_columns(t.depth_stamps.emplace(), depth);
    t.depth_frames = depth.table(layout::kDepthFrames, H5Type::u16, {kDepthHeight, kDepthWidth});
  }
  return t;
}

}  // namespace

SensorTables open_sensor_tables(const H5Node& sensor, bool complete) {
  SensorTables t = open_all(sensor);
  check_rows(t);
  if (!complete) accept_torn_ends(t);
  const auto limits = flushed_rows(sensor, complete);
  const CommonRows frame_rows = common_rows(t.frames);
  const CommonRows body_rows = common_rows(t.bodies);
  index_bodies(t, std::min(frame_rows.rows, limits[0]), std::min(body_rows.rows, limits[1]), complete);
  t.counts.torn_rows = frame_rows.most - t.counts.body_frames + body_rows.most - t.counts.bodies;
  if (t.depth_frames) count_depth(t, limits[2]);
  t.counts.clock_exchanges = std::min(t.lists.clock_exchanges.table.rows(), limits[3]);
  t.counts.drop_counts = std::min(t.lists.drop_counts.table.rows(), limits[4]);
  const std::uint64_t notices = std::min(common_rows(t.notices).rows, limits[5]);
  t.counts.notices = std::min(notices, kMaxSessionNotices);
  t.counts.notices_left_out = notices - t.counts.notices;
  return t;
}

}  // namespace trilat
