// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "datasets/depth/depth_rays.h"
#include "datasets/synthetic/depth/depth_renderer.h"

namespace trilat {

// One simulated Kinect of the study, as what it renders with and what its depth is read with.
struct StudyUnit {
  DepthUnit depth;
  DepthRays rays;
  DepthRenderer renderer;
};

// Optics and depth errors are functions of the seed and the unit's number; the declared noise model.
StudyUnit draw_study_unit(std::uint64_t seed, std::uint64_t unit);

}  // namespace trilat
