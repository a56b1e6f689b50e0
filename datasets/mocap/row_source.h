// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "datasets/mocap/mocap_take.h"

namespace trilat {

// Beyond a kilometre no number of a room-sized tracking system makes sense.
inline constexpr double kFarthest_m = 1000.0;
// 30 years: no clock of a take shows more.
inline constexpr double kLatest_s = 1e9;

// The rows behind the header of an export; one implementation for each family of formats.
class RowSource {
 public:
  virtual ~RowSource() = default;
  virtual void read_only(const std::vector<std::size_t>& assets) = 0;
  // Time strictly advances from frame to frame; rows that do not advance are dropped and counted.
  virtual bool next(MocapFrame& frame, MocapAnomalies& anomalies) = 0;
};

// `x, y, z, w` as printed, normalised; NaN when the length is not 1 within what six decimals and
// single precision explain.
Eigen::Quaterniond rotation_from_printed(double x, double y, double z, double w);

// Degrees about x, y, z, applied in `order` ("XYZ": about x, then the new y, then the new z), as
// Motive has it since 1.6 (help.naturalpoint.com, "Changes in Motive's reported Euler angles").
Eigen::Quaterniond rotation_from_euler(double x_deg, double y_deg, double z_deg, std::string_view order);
bool is_euler_order(std::string_view text);

// Mirrors z: the right-handed pose of what a left-handed export describes.
void make_right_handed(MocapPose& pose);

// round(frames / rate), exact in integers; the rate in millionths of a hertz, 1 Hz to 9 kHz.
Duration duration_of_frames(std::int64_t frames, std::int64_t rate_uhz);

}  // namespace trilat
