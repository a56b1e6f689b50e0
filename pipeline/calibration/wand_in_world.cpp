// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_in_world.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/mocap/read_mocap.h"

namespace trilat {

std::optional<FloorPlane> floor_seen_by(const SessionReader& session, std::size_t sensor) {
  const std::uint64_t frames = session.counts(sensor).body_frames;
  for (std::uint64_t row = 0; row < frames; row += std::max<std::uint64_t>(1, frames / 100)) {
    const auto floor = session.body_frames(sensor, row, 1)[0].floor_plane;
    const Eigen::Vector3d normal(floor[0], floor[1], floor[2]);
    if (std::abs(normal.norm() - 1.0) < 0.05 && std::isfinite(floor[3]))
      return FloorPlane{normal.normalized(), double{floor[3]}};
  }
  return std::nullopt;
}

namespace {

constexpr double kStill_m = 0.005;

struct PointMean {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d first_m = Eigen::Vector3d::Zero();
  double farthest_m = 0.0;
  double squares_m2 = 0.0;  // of the distances from the first
  int samples = 0;

  void add(const Eigen::Vector3d& position_m) {
    if (samples++ == 0) first_m = position_m;
    sum_m += position_m;
    farthest_m = std::max(farthest_m, (position_m - first_m).norm());
    squares_m2 += (position_m - first_m).squaredNorm();
  }
  Eigen::Vector3d mean_m() const { return sum_m / samples; }
  // Variance of the mean, an axis. One sample alone has no scatter.
  double variance_m2() const {
    if (samples < 2) return 0.0;
    const double scatter_m2 = squares_m2 - samples * (mean_m() - first_m).squaredNorm();
    return scatter_m2 / (3.0 * (samples - 1) * samples);
  }
};

}  // namespace

WandTrack read_wand_track(const std::filesystem::path& mocap, const std::string& asset_name) {
  const MocapHeader header = read_mocap_header(mocap);
  const std::size_t asset = find_asset(header, asset_name, mocap.string());
  if (!header.assets[asset].has_position)
    throw InputError(mocap.string(), "holds no position of \"" + asset_name + "\"");
  const MocapTake take = read_mocap(mocap, {.assets = {{asset}}});
  WandTrack track;
  for (std::size_t f = 0; f < take.time.size(); ++f) {  // a wand at rest may repeat a pose to the last digit
    const Eigen::Vector3d& position_m = take.position_m[asset][f];
    if (!position_m.allFinite() || position_m.isZero(0.0)) continue;
    track.times.push_back(take.time[f]);
    track.position_m.push_back(position_m);
  }
  return track;
}

std::vector<ControlPoint> known_positions(const WandInWorld& world, std::span<const WandPosition> positions) {
  const WandTrack track = world.track ? *world.track : read_wand_track(world.mocap, world.asset);
  std::vector<PointMean> means(positions.size());
  for (std::size_t i = 0; i < track.times.size(); ++i) {
    const HostTime time{world.mocap_start_host_ns + track.times[i].ns};
    for (std::size_t p = 0; p < positions.size(); ++p)
      if (positions[p].first <= time && time <= positions[p].last) means[p].add(track.position_m[i]);
  }
  std::vector<ControlPoint> known;
  for (std::size_t p = 0; p < positions.size(); ++p)
    if (means[p].samples > 0 && means[p].farthest_m <= kStill_m)
      known.push_back(
          {p, means[p].mean_m(), std::sqrt(world.sigma_m * world.sigma_m + means[p].variance_m2())});
  if (known.size() < 3)
    throw InputError(world.mocap.string(),
                     fmt::format("shows \"{}\" at rest at {} of the {} wand positions; three are needed. Is "
                                 "the start of the export on the host clock right?",
                                 world.asset, known.size(), positions.size()));
  return known;
}

}  // namespace trilat
