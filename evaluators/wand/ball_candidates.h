// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/depth/depth_image.h"

namespace trilat {

// Part of an image, seen at every `stride`-th pixel.
struct ImageWindow {
  int left_px = 0;
  int top_px = 0;
  int width_px = 0;
  int height_px = 0;
  int stride = 1;
};

// A pixel that lies about as deep inside a smooth patch as a ball's middle would.
struct BallCandidate {
  int column = 0;
  int row = 0;
  double depth_m = 0.0;    // of the surface
  double inside_px = 0.0;  // to the patch's nearest depth step, in pixels of the whole image
};

struct BallCandidateOptions {
  double ball_radius_m = 0.075;
  double focal_length_px = 365.0;
  // Distance of a candidate from the nearest depth step, in radii: hidden balls have less, the steep rim and
  // the width of a step take some, heads and walls have more.
  double least_inside = 0.45;
  double most_inside = 1.15;
};

// Patches end where depth steps. A thin stick interrupts a patch's outline without changing how far the
// middle is from it, so it needs no removal. Row by row; one candidate for each local maximum.
std::vector<BallCandidate> ball_candidates(const DepthImageView& image, const ImageWindow& window,
                                           const BallCandidateOptions& options);

}  // namespace trilat
