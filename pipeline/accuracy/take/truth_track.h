// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/time.h"
#include "datasets/mocap/mocap_reader.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

// The mapped joints of an OptiTrack export as a function of mocap time, read as far as it is asked for. Each
// asset is interpolated by itself between its two nearest samples, never across more than `longest_gap`;
// frozen stretches are no samples. A joint is the mean of its assets and is there only when all of them are:
// the mean of the rest would be another point.
class TruthTrack {
 public:
  // Of a take that is looked into as far as its mapping and the axis that points up. `joints` in the order
  // wanted; those that the mapping does not map are never there. InputError for an asset that does not exist,
  // has no position, or is a bone in local coordinates.
  TruthTrack(const PlannedTake& planned, const std::vector<Joint>& joints, Duration longest_gap);
  ~TruthTrack();
  TruthTrack(TruthTrack&&) noexcept;

  // One point a joint in the world, metres, NaN where there is none.
  void at(MocapTime t, std::span<Eigen::Vector3d> joints);
  // The last frame's time. Reads to the end of the export.
  MocapTime read_to_end();
  RemovedPoses removed() const;  // of the mapped assets, so far
  // The share of the frames so far that hold the same positions as the frame before, to the bit.
  double repeated_share() const;
  // Of what has been read so far.
  const MocapAnomalies& anomalies() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
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
                            TruthTrack& truth, const std::function<bool()>& stop_requested);

}  // namespace trilat
