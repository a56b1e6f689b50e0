// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/hdf5/hdf5_file.h"
#include "datasets/session/session_types.h"

// The layout of session.h5, format 1, stated once for writer and reader. FORMATS.md describes it for
// other programs.
namespace trilat::session_layout {

inline constexpr const char* kFormat = "trilat.session";
inline constexpr std::int64_t kVersion = 1;

struct Column {
  const char* name;
  H5Type type;
  std::vector<std::uint64_t> row_shape;
};

// /sensors/NAME/body_frames: one row a frame.
inline const std::vector<Column> kBodyFrameColumns{{"sequence", H5Type::i64, {}},
                                                   {"device_ticks", H5Type::i64, {}},
                                                   {"arrival_ns", H5Type::i64, {}},
                                                   {"floor_plane", H5Type::f32, {4}},
                                                   {"body_count", H5Type::u8, {}}};
// /sensors/NAME/bodies: one row a body and frame, in the order of the frames.
inline const std::vector<Column> kBodyColumns{{"frame", H5Type::u64, {}},
                                              {"tracking_id", H5Type::u64, {}},
                                              {"position_m", H5Type::f32, {kJointCount, 3}},
                                              {"orientation_xyzw", H5Type::f32, {kJointCount, 4}},
                                              {"tracking_state", H5Type::u8, {kJointCount}},
                                              {"hand_state", H5Type::u8, {2}},
                                              {"hand_confidence", H5Type::u8, {2}}};
// /sensors/NAME/depth: one row a frame.
inline const std::vector<Column> kDepthStampColumns{
    {"sequence", H5Type::i64, {}}, {"device_ticks", H5Type::i64, {}}, {"arrival_ns", H5Type::i64, {}}};
inline const Column kDepthFrames{"frame_mm", H5Type::u16, {kDepthHeight, kDepthWidth}};
// /sensors/NAME: t1 t2 t3 t4; and host_ns, at_source, in_queue.
inline const Column kClockExchanges{"clock_exchanges_ns", H5Type::i64, {4}};
inline const Column kDropCounts{"drop_counts", H5Type::i64, {3}};
// /sensors/NAME/notices: one row a notice; UTF-8, zeros behind.
inline constexpr std::uint64_t kNoticeBytes = 240;
inline const std::vector<Column> kNoticeColumns{{"host_ns", H5Type::i64, {}},
                                                {"text", H5Type::u8, {kNoticeBytes}}};
// /sensors/NAME: rows that were safely in the file, one row a flush, written behind them: body frames,
// bodies, depth frames, clock exchanges, drop counts, notices.
inline const Column kFlushed{"flushed", H5Type::i64, {6}};

}  // namespace trilat::session_layout
