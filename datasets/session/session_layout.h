// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "datasets/session/session_types.h"

// The layout of session.h5, format 1, stated once for writer and reader. FORMATS.md describes it for other
// programs.
namespace trilat::session_layout {

inline constexpr const char* kFormat = "trilat.session";
inline constexpr std::int64_t kVersion = 1;

// The tables of a sensor. Column<T> is what a writer or a reader has of a column whose elements are T;
// columns(tables, visit) calls visit(name, column, extents of a row...) for each.
template <template <class> class Column>
struct Stamps {
  Column<std::int64_t> sequence, device_ticks, arrival_ns;

  static void columns(auto& self, const auto& visit) {
    visit("sequence", self.sequence);
    visit("device_ticks", self.device_ticks);
    visit("arrival_ns", self.arrival_ns);
  }
};
// /sensors/NAME/body_frames: one row a frame.
template <template <class> class Column>
struct BodyFrames {
  Stamps<Column> stamps;
  Column<float> floor_plane;
  Column<std::uint8_t> body_count;

  static void columns(auto& self, const auto& visit) {
    Stamps<Column>::columns(self.stamps, visit);
    visit("floor_plane", self.floor_plane, 4);
    visit("body_count", self.body_count);
  }
};
// /sensors/NAME/bodies: one row a body and frame, in the order of the frames.
template <template <class> class Column>
struct Bodies {
  Column<std::uint64_t> frame, tracking_id;
  Column<float> position_m, orientation;
  Column<std::uint8_t> tracking_state, hand_state, hand_confidence;

  static void columns(auto& self, const auto& visit) {
    visit("frame", self.frame);
    visit("tracking_id", self.tracking_id);
    visit("position_m", self.position_m, kJointCount, 3);
    visit("orientation_xyzw", self.orientation, kJointCount, 4);
    visit("tracking_state", self.tracking_state, kJointCount);
    visit("hand_state", self.hand_state, 2);
    visit("hand_confidence", self.hand_confidence, 2);
  }
};
// /sensors/NAME: t1 t2 t3 t4; and host_ns, at_source, in_queue.
template <template <class> class Column>
struct Lists {
  Column<std::int64_t> clock_exchanges, drop_counts;

  static void columns(auto& self, const auto& visit) {
    visit("clock_exchanges_ns", self.clock_exchanges, 4);
    visit("drop_counts", self.drop_counts, 3);
  }
};
// /sensors/NAME/notices: one row a notice; UTF-8, zeros behind.
inline constexpr std::uint64_t kNoticeBytes = 240;
template <template <class> class Column>
struct Notices {
  Column<std::int64_t> host_ns;
  Column<std::uint8_t> text;

  static void columns(auto& self, const auto& visit) {
    visit("host_ns", self.host_ns);
    visit("text", self.text, kNoticeBytes);
  }
};
// /sensors/NAME/depth, beside its Stamps: one row a frame, of uint16.
inline constexpr const char* kDepthFrames = "frame_mm";
// /sensors/NAME: rows that were safely in the file, one row a flush, written behind them: body frames,
// bodies, depth frames, clock exchanges, drop counts, notices.
inline constexpr const char* kFlushed = "flushed";
inline constexpr std::uint64_t kFlushedNumbers = 6;

}  // namespace trilat::session_layout
