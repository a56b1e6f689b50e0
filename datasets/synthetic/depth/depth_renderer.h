// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "datasets/base/philox.h"
#include "datasets/rig/depth_camera.h"
#include "datasets/rig/depth_rays.h"
#include "datasets/rig/rigid_transform.h"
#include "datasets/synthetic/depth/room_scene.h"

namespace trilat {

// How a Kinect v2's depth differs from geometry. Declared assumptions; sources in
// docs/explanation/simulator.md.
struct DepthNoiseSpec {
  AxialNoise axial;
  double lateral_sigma_m = 0.0016;  // sideways jitter of the ray at the surface
  double corner_noise_factor =
      2.0;  // on the axial noise in the image's corner, rising with the square of the radius
  double offset_limit_m = 0.024;  // constant offset of a unit, uniform in +-
  double wiggle_amplitude_low_m = 0.002, wiggle_amplitude_high_m = 0.005;  // uniform between units
  double wiggle_length_low_m = 0.6, wiggle_length_high_m = 2.0;
  double edge_step_m = 0.05;        // neighbours that differ by more make an edge pixel
  double edge_dropped_share = 0.8;  // of edge pixels are invalid; the others lie between both surfaces
  double grazing_limit_rad = 1.3089969389957472;  // 75 degrees: beyond, nothing comes back
  double valid_radius = 0.84;  // normalised image radius beyond which nothing is seen (dark corners)
  double nearest_m = 0.5;
  double farthest_m = 8.0;
};
// No noise, no offset, no lost pixels from 1 mm to 65 m; depths are rounded to millimetres as ever.
DepthNoiseSpec noise_free_depth();

// Constants of one unit: measured = true + offset + amplitude sin(2 pi true / length + phase).
struct DepthUnit {
  double offset_m = 0.0;
  double wiggle_amplitude_m = 0.0;
  double wiggle_length_m = 1.0;
  double wiggle_phase_rad = 0.0;

  double error_m(double true_m) const;
};
DepthUnit draw_depth_unit(const DepthNoiseSpec& spec, std::uint64_t seed, std::uint64_t sensor);

// Renders what one sensor sees. Holds the rays of its pixels; one renderer may be used by several threads.
// Planes are seen from their front only; a sensor inside a sphere or capsule looks through it.
class DepthRenderer {
 public:
  DepthRenderer(const DepthIntrinsics& intrinsics, const DepthNoiseSpec& noise, const DepthUnit& unit);
  ~DepthRenderer();
  DepthRenderer(DepthRenderer&&) noexcept;

  // Millimetres, 0 invalid, into width x height values. The noise of a pixel is a function of `frame_key`
  // (its seed, purpose and item) and the pixel only. The same bits on every processor. An edge pixel is mixed
  // with the neighbour that differs most; next to nothing it keeps its depth when it is not lost.
  void render(const DepthScene& scene, const RigidTransform& world_from_sensor, const RandomStream& frame_key,
              std::span<std::uint16_t> depth_mm) const;
  // Renders the geometry without noise, offset, losses or rounding: metres along z, NaN where nothing is
  // seen.
  void render_exact(const DepthScene& scene, const RigidTransform& world_from_sensor,
                    std::span<float> depth_m) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace trilat
