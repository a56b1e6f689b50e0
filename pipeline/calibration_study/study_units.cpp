// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/study_units.h"

#include "datasets/synthetic/simulated_sensor.h"

namespace trilat {

StudyUnit draw_study_unit(std::uint64_t seed, std::uint64_t unit) {
  const DepthNoiseSpec noise;
  const DepthIntrinsics intrinsics = draw_sensor(SensorSpec{}, {seed, 0, 0}, unit, {}).intrinsics;
  const DepthUnit depth = draw_depth_unit(noise, seed, unit);
  return {depth, depth_rays(intrinsics), DepthRenderer(intrinsics, noise, depth)};
}

}  // namespace trilat
