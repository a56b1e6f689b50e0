// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "datasets/rig/depth_rays.h"
#include "datasets/session/session_reader.h"
#include "pipeline/calibration_study/place_samples.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr int kMiddleRow = kDepthHeight / 2;
constexpr double kOnWall_m = 0.03;
constexpr double kMinShareOnWall = 0.8;

// Sums over the frames of one sensor, by pixel.
struct PixelSums {
  std::vector<double> sum_m = std::vector<double>(kDepthPixels, 0.0), squares_m2 = sum_m;
  std::vector<std::uint32_t> count = std::vector<std::uint32_t>(kDepthPixels, 0);

  void add(const std::vector<std::uint16_t>& depth_mm) {
    for (std::size_t i = 0; i < depth_mm.size(); ++i) {
      if (depth_mm[i] == 0) continue;
      const double depth_m = kMetresPerMillimetre * depth_mm[i];
      sum_m[i] += depth_m;
      squares_m2[i] += depth_m * depth_m;
      ++count[i];
    }
  }
  double mean_m(std::size_t i) const { return sum_m[i] / count[i]; }
  double deviation_m(std::size_t i) const {
    const double n = count[i], mean = mean_m(i);
    return std::sqrt(std::max(0.0, (squares_m2[i] - n * mean * mean) / (n - 1.0)));
  }
};

// The wall as z = at_axis + x_slope x + y_slope y in the sensor's frame.
struct WallPlane {
  double at_axis_m = 0.0, x_slope = 0.0, y_slope = 0.0;

  // Where a ray (x, y, 1) meets it.
  double depth_m(double x, double y) const { return at_axis_m / (1.0 - x_slope * x - y_slope * y); }
  double tilt_rad() const { return std::atan(std::hypot(x_slope, y_slope)); }
};

struct FittedWall {
  WallPlane plane;
  double share = 0.0;  // of the pixels with a depth that lie on it
};

// Least squares over the pixels within a distance of the plane before, which narrows to kOnWall_m.
FittedWall fit_wall(const PixelSums& sums, const DepthRays& rays) {
  std::vector<std::size_t> pixels;
  std::vector<double> depths_m;
  for (std::size_t i = 0; i < kDepthPixels; ++i)
    if (sums.count[i] > 0 && std::isfinite(rays.x[i])) {
      pixels.push_back(i);
      depths_m.push_back(sums.mean_m(i));
    }
  if (pixels.empty()) return {};
  FittedWall wall{{median(depths_m), 0.0, 0.0}, 0.0};
  for (const double within_m : {1e9, 0.5, 0.2, 0.1, 0.05, kOnWall_m, kOnWall_m, kOnWall_m}) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    std::size_t used = 0;
    for (const std::size_t i : pixels) {
      const double x = double{rays.x[i]}, y = double{rays.y[i]}, depth_m = sums.mean_m(i);
      if (!(std::abs(depth_m - wall.plane.depth_m(x, y)) <= within_m)) continue;
      const Eigen::Vector3d row(1.0, depth_m * x, depth_m * y);
      normal += row * row.transpose();
      right += depth_m * row;
      ++used;
    }
    wall.share = static_cast<double>(used) / static_cast<double>(pixels.size());
    if (used < 3) return wall;
    const Eigen::Vector3d plane = normal.ldlt().solve(right);
    wall.plane = {plane[0], plane[1], plane[2]};
  }
  return wall;
}

double noise_of(const PixelSums& sums, const DepthRays& rays, const WallPlane& plane) {
  std::vector<double> deviations_m;
  for (std::size_t i = 0; i < kDepthPixels; ++i)
    if (sums.count[i] > 1 && std::isfinite(rays.x[i]) &&
        std::abs(sums.mean_m(i) - plane.depth_m(double{rays.x[i]}, double{rays.y[i]})) <= kOnWall_m)
      deviations_m.push_back(sums.deviation_m(i));
  return deviations_m.empty() ? kNaN : median(std::move(deviations_m));
}

// Mean absolute errors of the middle row's columns over all frames: of the depth from the plane, and of a
// point's place across the view by eq. 4 as printed.
void add_columns(const SessionReader& session, std::size_t sensor, const DepthRays& rays,
                 const WallPlane& plane, const RunControl& control, WallRow& row) {
  row.residual_m.assign(kDepthWidth, 0.0);
  row.printed_error_m.assign(kDepthWidth, 0.0);
  std::vector<std::uint64_t> count(kDepthWidth, 0);
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  for (std::uint64_t f = 0; f < row.frames; ++f) {
    control.check();
    session.depth_frame(sensor, f, depth_mm);
    for (int c = 0; c < kDepthWidth; ++c) {
      const std::size_t i = rays.index(c, kMiddleRow);
      if (depth_mm[i] == 0 || !std::isfinite(rays.x[i])) continue;
      const double depth_m = kMetresPerMillimetre * depth_mm[i];
      const double wall_m = plane.depth_m(double{rays.x[i]}, double{rays.y[i]});
      const auto column = static_cast<std::size_t>(c);
      row.residual_m[column] += std::abs(depth_m - wall_m);
      row.printed_error_m[column] +=
          std::abs(printed_linear_angle_point({c, kMiddleRow}, depth_m).x() - wall_m * double{rays.x[i]});
      ++count[column];
    }
  }
  for (std::size_t c = 0; c < count.size(); ++c)
    for (auto* sums : {&row.residual_m, &row.printed_error_m})
      (*sums)[c] = count[c] == 0 ? kNaN : (*sums)[c] / static_cast<double>(count[c]);
}

WallRow measure_sensor(const SessionReader& session, std::size_t sensor, const RunControl& control) {
  WallRow row;
  row.sensor = session.header().sensors[sensor].name;
  row.frames = session.counts(sensor).depth_frames;
  const std::string place = session.path().string() + ":/sensors/" + row.sensor;
  if (row.frames == 0) throw InputError(place, "has no depth frames, in which a wall could be seen");
  const DepthRays rays = depth_rays(session.header().sensors[sensor].intrinsics);
  PixelSums sums;
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  for (std::uint64_t f = 0; f < row.frames; ++f) {
    control.check();
    session.depth_frame(sensor, f, depth_mm);
    sums.add(depth_mm);
  }
  const FittedWall wall = fit_wall(sums, rays);
  if (!(wall.share >= kMinShareOnWall))
    throw InputError(
        place, fmt::format("sees no flat wall: {:.0f} % of its pixels with a depth lie within {:g} cm of "
                           "one plane, and {:.0f} % are needed; point it squarely at a flat wall that "
                           "fills its image",
                           100.0 * wall.share, kOnWall_m * kCentimetresPerMetre, 100.0 * kMinShareOnWall));
  row.distance_m = wall.plane.at_axis_m;
  row.tilt_rad = wall.plane.tilt_rad();
  row.noise_m = noise_of(sums, rays, wall.plane);
  add_columns(session, sensor, rays, wall.plane, control, row);
  return row;
}

}  // namespace

WallRecording measure_wall(const FlatWall& wall, const RunControl& control) {
  const SessionReader session(wall.session);
  WallRecording recording;
  recording.simulated = session.header().simulated;
  recording.rows.resize(session.header().sensors.size());
  parallel_for_index(recording.rows.size(), 1, [&](std::size_t s) {
    recording.rows[s] = measure_sensor(session, s, control);
    recording.rows[s].stated_m = wall.distance_m.value_or(kNaN);
  });
  constexpr double kMaxOff_m = 0.15;
  for (const WallRow& row : recording.rows)
    if (std::abs(row.distance_m - row.stated_m) > kMaxOff_m)
      throw InputError(
          wall.session.string() + ":/sensors/" + row.sensor,
          fmt::format("sees the wall at {:.2f} m, and \"distance_m\" is {:g}; state how far the wall was "
                      "from the sensors, or leave it out",
                      row.distance_m, row.stated_m));
  return recording;
}

}  // namespace trilat
