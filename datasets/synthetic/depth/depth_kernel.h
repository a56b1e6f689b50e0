// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "datasets/base/philox.h"
#include "datasets/synthetic/depth/depth_view.h"

namespace trilat {

// Arguments of the depth renderer's vector code.

// Layout of a padded image: a row above and below and a few columns on either side, so that vectors
// and neighbours need no special case at the border.
struct DepthLayout {
  static constexpr int kPad = 16;  // columns; the widest vector of floats
  int width_px = 0, height_px = 0;

  std::size_t stride() const { return static_cast<std::size_t>((width_px + 3 * kPad - 1) / kPad * kPad); }
  // The first pixel of a row; -1 and height_px are the rows of padding.
  std::size_t row(int number) const { return static_cast<std::size_t>(number + 1) * stride() + kPad; }
  std::size_t size() const { return static_cast<std::size_t>(height_px + 2) * stride(); }
};

// Which pixels each object of a view may cover.
struct ViewBoxes {
  std::vector<PixelBox> spheres, capsules;
};

// Casts the rays as they are: depth into a padded image, infinite where nothing is met. Returns the least.
float cast_depth(const DepthLayout& layout, const DepthView& view, const ViewBoxes& boxes, const float* ray_x,
                 const float* ray_y, float* depth_m);

// Noise in the numbers that the vector code uses.
struct DepthNoiseNumbers {
  float level_m, slope, square_per_m, angle;  // sigma_m = level + slope z + square z^2 + angle z^(3/2) …
  float lateral_sigma_m;
  float offset_m, wiggle_amplitude_m, wiggle_per_m, wiggle_turn;  // turn: phase as a share of a turn
  float edge_step_m, edge_dropped_share;
  float least_cosine;
  float nearest_m, farthest_m;
};

// Casts jittered rays and makes of them what the sensor would give, millimetres. `exact_m`: what cast_depth()
// gave, with its border filled. `boxes` must have room for the jitter. `noise_factor`, padded, scales the
// axial noise of a pixel; below 0 the pixel is invalid.
void render_depth(const DepthLayout& layout, const DepthView& view, const ViewBoxes& boxes,
                  const DepthNoiseNumbers& noise, const RandomStream& frame_key, const float* ray_x,
                  const float* ray_y, const float* noise_factor, const float* exact_m,
                  std::uint16_t* depth_mm);

// No normal that the vector code draws is larger.
inline constexpr double kMaxNormal = 5.8;
// Which index of a frame's stream is drawn for what: a pixel's number, row by row, gives its three normals;
// with this added, what becomes of it at an edge.
inline constexpr std::uint32_t kEdgeIndex = 0x80000000;

}  // namespace trilat
