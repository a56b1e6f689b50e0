// SPDX-License-Identifier: MIT
#include "datasets/synthetic/depth/depth_renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "datasets/base/error.h"
#include "datasets/synthetic/depth/depth_kernel.h"

namespace trilat {
namespace {

// Pixels row by row become a padded image.
std::vector<float> padded(const DepthLayout& layout, const std::vector<float>& pixels, float border) {
  std::vector<float> image(layout.size(), border);
  for (int row = 0; row < layout.height_px; ++row)
    std::copy_n(pixels.begin() + static_cast<std::ptrdiff_t>(row) * layout.width_px, layout.width_px,
                image.begin() + static_cast<std::ptrdiff_t>(layout.row(row)));
  return image;
}

// Rises with the square of the normalised radius from 1 to the corner's factor; -1 where nothing is seen.
std::vector<float> noise_factors(const DepthRays& rays, const DepthNoiseSpec& spec) {
  const auto square = [&](std::size_t i) {
    return static_cast<double>(rays.x[i]) * static_cast<double>(rays.x[i]) +
           static_cast<double>(rays.y[i]) * static_cast<double>(rays.y[i]);
  };
  double largest = 0.0;
  for (std::size_t i = 0; i < rays.x.size(); ++i)
    if (square(i) > largest) largest = square(i);
  std::vector<float> factors(rays.x.size(), -1.0f);
  for (std::size_t i = 0; i < rays.x.size(); ++i)
    if (square(i) <= spec.valid_radius * spec.valid_radius)
      factors[i] = static_cast<float>(1.0 + (spec.corner_noise_factor - 1.0) * square(i) / largest);
  return factors;
}

DepthNoiseNumbers numbers_of(const DepthNoiseSpec& spec, const DepthUnit& unit) {
  const auto f = [](double value) { return static_cast<float>(value); };
  const double turn = unit.wiggle_phase_rad / (2.0 * std::numbers::pi);
  return {f(1e-3 * spec.axial.level_mm),
          f(1e-3 * spec.axial.slope_mm),
          f(1e-3 * spec.axial.square_mm),
          f(1e-3 * spec.axial.angle_mm),
          f(spec.lateral_sigma_m),
          f(unit.offset_m),
          f(unit.wiggle_amplitude_m),
          f(1.0 / unit.wiggle_length_m),
          f(turn - std::floor(turn)),
          f(spec.edge_step_m),
          f(spec.edge_dropped_share),
          f(std::cos(spec.grazing_limit_rad)),
          f(spec.nearest_m),
          f(spec.farthest_m)};
}

ViewBoxes boxes_of(const DepthView& view, const PixelBoxFinder& finder, double margin) {
  ViewBoxes boxes;
  for (const ViewSphere& sphere : view.spheres) boxes.spheres.push_back(finder.pixels_of(sphere.box, margin));
  for (const ViewCapsule& capsule : view.capsules)
    boxes.capsules.push_back(finder.pixels_of(capsule.box, margin));
  return boxes;
}

// The border repeats the image, so that it makes no edges.
void fill_border(const DepthLayout& layout, std::vector<float>& image) {
  for (int row = 0; row < layout.height_px; ++row) {
    float* first = image.data() + layout.row(row);
    first[-1] = first[0];
    first[layout.width_px] = first[layout.width_px - 1];
  }
  std::copy_n(image.begin() + static_cast<std::ptrdiff_t>(layout.row(0)), layout.width_px,
              image.begin() + static_cast<std::ptrdiff_t>(layout.row(-1)));
  std::copy_n(image.begin() + static_cast<std::ptrdiff_t>(layout.row(layout.height_px - 1)), layout.width_px,
              image.begin() + static_cast<std::ptrdiff_t>(layout.row(layout.height_px)));
}

}  // namespace

DepthNoiseSpec noise_free_depth() {
  constexpr double kWithout = std::numeric_limits<double>::infinity();
  DepthNoiseSpec spec;
  spec.axial = {0.0, 0.0, 0.0, 0.0};
  spec.lateral_sigma_m = 0.0;
  spec.corner_noise_factor = 1.0;
  spec.offset_limit_m = 0.0;
  spec.wiggle_amplitude_low_m = spec.wiggle_amplitude_high_m = 0.0;
  spec.edge_step_m = kWithout;
  spec.edge_dropped_share = 0.0;
  spec.grazing_limit_rad = std::numbers::pi / 2.0;
  spec.valid_radius = kWithout;
  spec.nearest_m = 0.001;
  spec.farthest_m = 65.0;
  return spec;
}

double DepthUnit::error_m(double true_m) const {
  return offset_m +
         wiggle_amplitude_m * std::sin(2.0 * std::numbers::pi * true_m / wiggle_length_m + wiggle_phase_rad);
}

DepthUnit draw_depth_unit(const DepthNoiseSpec& spec, std::uint64_t seed, std::uint64_t sensor) {
  const RandomStream random{seed, Purpose::depth_unit, sensor};
  return {random.uniform(0, -spec.offset_limit_m, spec.offset_limit_m),
          random.uniform(1, spec.wiggle_amplitude_low_m, spec.wiggle_amplitude_high_m),
          random.uniform(2, spec.wiggle_length_low_m, spec.wiggle_length_high_m),
          random.uniform(3, 0.0, (2.0 * std::numbers::pi))};
}

struct DepthRenderer::State {
  State(const DepthRays& rays, const DepthNoiseSpec& spec, const DepthUnit& unit)
      : layout{rays.intrinsics.width_px, rays.intrinsics.height_px},
        finder(rays),
        ray_x(padded(layout, rays.x, std::numeric_limits<float>::quiet_NaN())),
        ray_y(padded(layout, rays.y, std::numeric_limits<float>::quiet_NaN())),
        noise_factor(padded(layout, noise_factors(rays, spec), -1.0f)),
        noise(numbers_of(spec, unit)),
        lateral_sigma_m(spec.lateral_sigma_m),
        nearest_m(spec.nearest_m) {}

  std::size_t pixels() const {
    return static_cast<std::size_t>(layout.width_px) * static_cast<std::size_t>(layout.height_px);
  }

  DepthLayout layout;
  PixelBoxFinder finder;
  std::vector<float> ray_x, ray_y, noise_factor;  // padded
  DepthNoiseNumbers noise;
  double lateral_sigma_m, nearest_m;
};

DepthRenderer::DepthRenderer(const DepthIntrinsics& intrinsics, const DepthNoiseSpec& noise,
                             const DepthUnit& unit) {
  TRILAT_CHECK(noise.nearest_m > 0.0 && noise.farthest_m < 65.5, "depths fit a depth image");
  state_ = std::make_unique<State>(depth_rays(intrinsics), noise, unit);
}
DepthRenderer::~DepthRenderer() = default;
DepthRenderer::DepthRenderer(DepthRenderer&&) noexcept = default;

void DepthRenderer::render(const DepthScene& scene, const RigidTransform& world_from_sensor,
                           const RandomStream& frame_key, std::span<std::uint16_t> depth_mm) const {
  const State& s = *state_;
  TRILAT_CHECK(depth_mm.size() == s.pixels(), "a depth image has room for its pixels");
  const DepthView view = depth_view(scene, world_from_sensor);
  std::vector<float> exact_m(s.layout.size(), std::numeric_limits<float>::infinity());
  const float least_m = cast_depth(s.layout, view, boxes_of(view, s.finder, 0.0), s.ray_x.data(),
                                   s.ray_y.data(), exact_m.data());
  fill_border(s.layout, exact_m);
  const double margin = kMaxNormal * s.lateral_sigma_m / std::max(s.nearest_m, static_cast<double>(least_m));
  render_depth(s.layout, view, boxes_of(view, s.finder, margin), s.noise, frame_key, s.ray_x.data(),
               s.ray_y.data(), s.noise_factor.data(), exact_m.data(), depth_mm.data());
}

void DepthRenderer::render_exact(const DepthScene& scene, const RigidTransform& world_from_sensor,
                                 std::span<float> depth_m) const {
  const State& s = *state_;
  TRILAT_CHECK(depth_m.size() == s.pixels(), "a depth image has room for its pixels");
  const DepthView view = depth_view(scene, world_from_sensor);
  std::vector<float> exact_m(s.layout.size());
  cast_depth(s.layout, view, boxes_of(view, s.finder, 0.0), s.ray_x.data(), s.ray_y.data(), exact_m.data());
  for (int row = 0; row < s.layout.height_px; ++row)
    for (int column = 0; column < s.layout.width_px; ++column) {
      const float value = exact_m[s.layout.row(row) + static_cast<std::size_t>(column)];
      depth_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(s.layout.width_px) +
              static_cast<std::size_t>(column)] =
          std::isinf(value) ? std::numeric_limits<float>::quiet_NaN() : value;
    }
}

}  // namespace trilat
