// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "datasets/rig/depth_rays.h"
#include "evaluators/wand/wand_sighting.h"

namespace trilat {

// Variant of an equation: as printed, or what it must have meant.
enum class Variant : std::uint8_t { printed, corrected };

// Eq. 2 and 3, E1: which pixels go on to the next label map, and when it ends. As printed a pixel goes on
// when D <= C Ave, and it ends when Min C >= Max, which never holds; corrected: when Min >= C Max. By the
// mid-range, C = 0.5025 is half of 1.005: a pixel goes on when D <= C (Min + Max), and it ends when all of
// them do (Max <= 1.0101 Min), because then no later label map differs.
enum class ThresholdRule : std::uint8_t { printed, corrected, mid_range };

// The paper's wand recognition (eq. 1 to 5) with a switch for each thing that cannot be so.
struct PrintedWandOptions {
  Variant invalid_pixels =
      Variant::printed;  // eq. 1 lifts them to 50 cm, the nearest of all; corrected: left out
  ThresholdRule binarisation = ThresholdRule::printed;
  Variant projection = Variant::printed;  // E2, eq. 4: linear in the angle; corrected: lens model
  Variant centre = Variant::printed;      // E3, eq. 5: z + width in pixels; corrected: radius along the ray
  double c_offset = 0.5025;
  double ball_radius_m = 0.075;  // for the corrected centre only
  int max_iterations = 100;      // reached only with c_offset >= 1: otherwise every step leaves less
};

// The position in the sensor's frame (the paper's client frame, y down, is turned). The covariance stays NaN:
// the paper states none. When the stop rule never holds (as printed, always) the status is `not_ended` and
// the position is that of the last pixels that were left; `no_wand` when already the first threshold leaves
// none. Looked at are D <= R of eq. 2 from the second label map on; the first, which is all ones, ends
// nothing.
[[nodiscard]] WandSighting find_wand_as_printed(const DepthImageView& image, const DepthRays& rays,
                                                const PrintedWandOptions& options);

}  // namespace trilat
