// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/time.h"
#include "datasets/mocap/mocap_reader.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

// The mapped joints of an OptiTrack export as a function of mocap time. Each asset is interpolated by itself
// between its two nearest samples, never across more than `longest_gap`; frozen stretches are no samples. A
// joint is the mean of its assets and is there only when all of them are: the mean of the rest would be
// another point.
class TruthTrack {
 public:
  // Reads the export of a take from its start up to the last instant asked for. `joints` in the order wanted;
  // those that the mapping does not map are never there. InputError for an asset that does not exist, has no
  // position, or is a bone in local coordinates.
  TruthTrack(const PlannedTake& planned, const std::vector<Joint>& joints, Duration longest_gap,
             MocapTime until = {std::numeric_limits<std::int64_t>::max()});

  // One point a joint in the world, metres, NaN where there is none.
  void at(MocapTime t, std::span<Eigen::Vector3d> joints) const;
  MocapTime end() const;  // the last frame's time
  const RemovedPoses& removed() const { return mocap_.removed; }
  const MocapAnomalies& anomalies() const { return mocap_.anomalies; }
  // The share of the frames that hold the same positions as the frame before, to the bit.
  double repeated_share() const;

 private:
  Eigen::Vector3d asset_at(std::size_t asset, std::size_t after, MocapTime t) const;

  MocapPositions mocap_;
  std::vector<std::vector<std::size_t>> assets_of_joint_;
  Duration longest_gap_;
  bool has_z_up_;
};

struct MotionClock {
  ClockRow row;
  std::string warning;  // what the trackers' lag does not explain, for the take's notes; empty when it does
};

// The likely cause why the motion does not say when the mocap starts, as a sentence; `status`: its name.
std::string cause_of(const std::string& status);

// By how much the mocap's stated start is off, as the motion shows: the mean of the sensors' positions
// against the ground truth. `data` has its times and bodies.
MotionClock clock_by_motion(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                            const TruthTrack& truth, const std::function<bool()>& stop_requested);

}  // namespace trilat
