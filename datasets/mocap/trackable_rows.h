// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/mocap/line_reader.h"
#include "datasets/mocap/trackable_header.h"

namespace trilat {

// Frames of the row formats. Time is the printed stamp, since no rate is stated and the stamps of version 1.0
// are irregular. Bodies come from the frame rows; their markers, solved and measured, from the extended rows.
// A body that the file calls untracked, and with it its solved markers, is missing. Markers that belong to no
// body are not delivered.
class TrackableRows : public RowSource {
 public:
  // `lines` must outlive the rows.
  TrackableRows(LineReader& lines, TrackableHeader header);
  void read_only(const std::vector<std::size_t>& assets) override;
  bool next(MocapFrame& frame, MocapAnomalies& anomalies) override;

 private:
  bool read_frame(std::string_view line, bool finished, MocapFrame& frame, MocapAnomalies& anomalies);
  void read_body(RowCells& cells, MocapFrame& frame, MocapAnomalies& anomalies) const;
  void read_extended_rows(MocapFrame& frame, MocapAnomalies& anomalies);
  void read_extended(std::string_view line, MocapFrame& frame, MocapAnomalies& anomalies) const;
  bool set_time(MocapFrame& frame, MocapAnomalies& anomalies);
  void set_position(std::size_t asset, const Eigen::Vector3d& position_m, MocapFrame& frame,
                    MocapAnomalies& anomalies) const;
  const TrackableBody& body_of(std::int64_t id) const;
  MocapPose* pose_of(std::size_t asset, MocapFrame& frame) const;

  LineReader& lines_;
  TrackableHeader header_;
  std::vector<char> wanted_;  // by asset
  bool started_ = false;
  double first_stamp_s_ = 0.0;
  double last_stamp_s_ = 0.0;
};

}  // namespace trilat
