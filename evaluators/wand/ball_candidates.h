// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "datasets/depth/depth_image.h"
#include "datasets/depth/depth_rays.h"
#include "evaluators/wand/ball_fit.h"

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

// The pixels around a ball's image, those where nothing was seen too; what lies far outside its image and the
// rays the lens model does not know are left out.
std::vector<RayDepth> pixels_around(const DepthImageView& image, const DepthRays& rays,
                                    const Eigen::Vector3d& centre_in_sensor_m, double radius_m);

// What lies on a circle somewhat larger than the ball's outline, in shares of the directions inside the
// image.
struct BallSurroundings {
  double beyond = 0.0;      // behind the ball's middle, or nothing was seen
  double continuing = 0.0;  // at the ball's depth: the thing is larger than a ball, or its stick
  double in_front = 0.0;    // something hides the ball there
  double unseen = 0.0;      // of those beyond: nothing was seen
};
BallSurroundings surroundings_of(const DepthImageView& image, const DepthRays& rays,
                                 const Eigen::Vector3d& centre_in_sensor_m, double radius_m,
                                 double circle_radius_m, int directions);

// Whether a ball may be where a search starts: what is seen on a small circle about the middle lies roughly
// where the ball's surface would (a floor is too steep, a rim too deep), and the thing does not go on around
// it.
bool worth_fitting(const DepthImageView& image, const DepthRays& rays,
                   const Eigen::Vector3d& centre_in_sensor_m, double radius_m);

// Whether the whole outline lies inside the image.
bool outline_in_image(const DepthIntrinsics& intrinsics, const Eigen::Vector3d& centre_in_sensor_m,
                      double radius_m);

// Why a fit is no ball; empty when it is one.
std::string_view not_a_ball(const DepthImageView& image, const DepthRays& rays, const BallFit& fit,
                            double radius_m);

// Whether more of the disc is invalid than lost pixels and the rim of something before the ball explain.
bool lacks_pixels(const DepthImageView& image, const DepthRays& rays, const BallFit& fit, double radius_m);

}  // namespace trilat
