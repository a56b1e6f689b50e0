// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/results/stored_take.h"
#include "evaluators/metrics/body_metrics.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/tracking_summary.h"

namespace trilat {

// How far predictions by one method are from what the sensor sees that is left out, summed over instants and
// joints: along its ray (length of the prediction's vector - length of what is seen) and across (distance of
// the prediction from the line of sight). Metres, before any alignment. Beside it what needs no second look:
// how much bones change their lengths (standard deviation in the take, by bone and instant), and the jerk of
// the joints, of four instants in a row.
struct PredictionSums {
  std::string participant, condition, method;
  std::uint64_t n = 0, bone_n = 0, jerk_n = 0;
  double range_m = 0.0, abs_range_m = 0.0, bearing_m = 0.0, bone_m = 0.0, jerk_m_s3 = 0.0;

  TRILAT_FIELDS(participant, condition, method, n, bone_n, jerk_n, range_m, abs_range_m, bearing_m, bone_m,
                jerk_m_s3)
};

// Adds up a take's blocks, which come in the order of time, for one sensor of the rig that is left out.
class Predictions {
 public:
  Predictions(const Plan& plan, const PlannedTake& planned, std::size_t left_out);
  void add(const SampleBlock& block);
  // An entry for every method of the plan.
  std::vector<PredictionSums> sums() const;

 private:
  struct Bone {
    std::size_t parent = 0, child = 0;  // joints of the plan
    LengthSpread length;
  };
  struct Track {
    std::vector<Bone> bones;
    std::vector<std::array<Eigen::Vector3d, 4>> last_m;  // by joint, the newest first; NaN where silent
  };
  void add(std::size_t method, std::span<const Eigen::Vector3d> joints_m);

  const Plan& plan_;
  RigidTransform sensor_from_world_;
  std::vector<PredictionSums> sums_;
  std::vector<Track> tracks_;  // by method
};

// By condition and method, in the order of their first take; intervals between participants.
std::vector<PredictionRow> prediction_rows(const std::vector<PredictionSums>& sums);

}  // namespace trilat
