// SPDX-License-Identifier: MIT
// Renders a room with a person by Highway's vectors and by plain loops over pixels that do the same, in one
// process: milliseconds a frame and how far the images differ.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <vector>

#include "datasets/synthetic/depth/depth_kernel.h"
#include "datasets/synthetic/depth/depth_renderer.h"
#include "datasets/synthetic/generated_person.h"

namespace {

using namespace trilat;

constexpr int kFrames = 40;
constexpr float kNothing = std::numeric_limits<float>::infinity();

struct Met {
  float depth_m = kNothing, cosine = 0.0f;
  void take(float depth, float cosine_of_it) {
    if (!(depth > 0.0f && depth < depth_m)) return;
    depth_m = depth;
    cosine = cosine_of_it;
  }
};

float dot(const FloatVector3& a, const FloatVector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Where a ray meets a sphere about the origin, from `start` on.
bool meet_sphere(const FloatVector3& start, const FloatVector3& ray, float radius, float& depth,
                 float& inside) {
  const float square = dot(ray, ray), to_nearest = -dot(start, ray) / square;
  const FloatVector3 nearest{start[0] + to_nearest * ray[0], start[1] + to_nearest * ray[1],
                             start[2] + to_nearest * ray[2]};
  inside = radius * radius - dot(nearest, nearest);
  depth = to_nearest - std::sqrt(std::max(inside, 0.0f) / square);
  return inside > 0.0f;
}

void meet_capsule(const ViewCapsule& c, const FloatVector3& ray, Met& met) {
  const float square = dot(ray, ray), closest = dot(c.middle_m, ray) / square;
  const FloatVector3 start{closest * ray[0] - c.from_m[0], closest * ray[1] - c.from_m[1],
                           closest * ray[2] - c.from_m[2]};
  const float axis_ray = dot(c.axis_m, ray), axis_start = dot(c.axis_m, start);
  const float a = c.axis_m2 * square - axis_ray * axis_ray;
  const float b = c.axis_m2 * dot(start, ray) - axis_start * axis_ray;
  const float h =
      b * b - a * (c.axis_m2 * (dot(start, start) - c.radius_m * c.radius_m) - axis_start * axis_start);
  const bool is_parallel = a <= 1e-6f * c.axis_m2 * square;
  if (!(h > 0.0f) && !is_parallel) return;
  const float root = std::sqrt(std::max(h, 0.0f)), to_side = (-b - root) / a;
  const float height = is_parallel ? -axis_ray : axis_start + to_side * axis_ray;
  if (!is_parallel && height > 0.0f && height < c.axis_m2)
    return met.take(closest + to_side, root / (c.axis_m2 * c.radius_m * std::sqrt(square)));
  FloatVector3 end = start;
  if (height > 0.0f)
    for (std::size_t k = 0; k < 3; ++k) end[k] -= c.axis_m[k];
  float depth = 0.0f, inside = 0.0f;
  if (meet_sphere(end, ray, c.radius_m, depth, inside))
    met.take(closest + depth, std::sqrt(std::max(inside, 0.0f)) / c.radius_m);
}

// Objects that may be met in a row.
struct RowObjects {
  std::vector<std::pair<const ViewSphere*, PixelBox>> spheres;
  std::vector<std::pair<const ViewCapsule*, PixelBox>> capsules;
};

Met cast(const DepthView& view, const RowObjects& objects, int column, const FloatVector3& ray) {
  Met met;
  float inverse = 0.0f, distance = 0.0f;
  for (const ViewPlane& plane : view.planes) {
    const float here = ray[0] * plane.per_x + ray[1] * plane.per_y + plane.constant;
    if (here > inverse) inverse = here, distance = plane.distance_m;
  }
  if (inverse > 0.0f) met = {1.0f / inverse, inverse * distance / std::sqrt(dot(ray, ray))};
  const auto is_in = [&](const PixelBox& box) {
    return column >= box.first_column && column < box.last_column;
  };
  for (const auto& [sphere, box] : objects.spheres) {
    if (!is_in(box)) continue;
    float depth = 0.0f, inside = 0.0f;
    const FloatVector3 start{-sphere->centre_m[0], -sphere->centre_m[1], -sphere->centre_m[2]};
    if (meet_sphere(start, ray, sphere->radius_m, depth, inside))
      met.take(depth, std::sqrt(inside) / sphere->radius_m);
  }
  for (const auto& [capsule, box] : objects.capsules)
    if (is_in(box)) meet_capsule(*capsule, ray, met);
  return met;
}

struct PlainRenderer {
  DepthRays rays;
  PixelBoxFinder finder{rays};
  DepthNoiseSpec spec;
  DepthUnit unit;
  double corner = 0.0;

  PlainRenderer(const DepthNoiseSpec& noise, const DepthUnit& of)
      : rays(depth_rays({})), spec(noise), unit(of) {
    for (std::size_t i = 0; i < rays.x.size(); ++i) corner = std::max(corner, square(i));
  }
  double square(std::size_t i) const {
    return static_cast<double>(rays.x[i] * rays.x[i]) + static_cast<double>(rays.y[i] * rays.y[i]);
  }

  std::vector<RowObjects> rows_of(const DepthView& view, double margin) const {
    std::vector<RowObjects> rows(static_cast<std::size_t>(rays.intrinsics.height_px));
    const auto enter = [&](const auto& objects, auto list) {
      for (const auto& object : objects) {
        const PixelBox box = finder.pixels_of(object.box, margin);
        for (int r = box.first_row; r < box.last_row; ++r)
          (rows[static_cast<std::size_t>(r)].*list).emplace_back(&object, box);
      }
    };
    enter(view.spheres, &RowObjects::spheres);
    enter(view.capsules, &RowObjects::capsules);
    return rows;
  }

  void render(const DepthScene& scene, const RigidTransform& pose, const RandomStream& key,
              std::vector<std::uint16_t>& depth_mm) const {
    const DepthView view = depth_view(scene, pose);
    const int width = rays.intrinsics.width_px, height = rays.intrinsics.height_px;
    std::vector<float> exact_m(rays.x.size());
    const auto at = [&](int row, int column) {
      return static_cast<std::size_t>(std::clamp(row, 0, height - 1) * width +
                                      std::clamp(column, 0, width - 1));
    };
    const std::vector<RowObjects> exact_rows = rows_of(view, 0.0),
                                  rows = rows_of(view, kMaxNormal * spec.lateral_sigma_m / spec.nearest_m);
    for (int r = 0; r < height; ++r)
      for (int c = 0; c < width; ++c)
        exact_m[at(r, c)] =
            cast(view, exact_rows[static_cast<std::size_t>(r)], c, {rays.x[at(r, c)], rays.y[at(r, c)], 1.0f})
                .depth_m;
    for (int r = 0; r < height; ++r)
      for (int c = 0; c < width; ++c) {
        const std::size_t i = at(r, c);
        depth_mm[i] = measure(
            view, rows[static_cast<std::size_t>(r)], c, i, key,
            {exact_m[at(r, c - 1)], exact_m[at(r, c + 1)], exact_m[at(r - 1, c)], exact_m[at(r + 1, c)]},
            exact_m[i]);
      }
  }

  std::uint16_t measure(const DepthView& view, const RowObjects& objects, int column, std::size_t i,
                        const RandomStream& key, const std::array<float, 4>& around, float exact) const {
    if (square(i) > spec.valid_radius * spec.valid_radius) return 0;
    const auto index = static_cast<std::uint32_t>(i);
    const std::array<double, 2> jitter = key.normal_pair(index);
    const float scale =
        static_cast<float>(spec.lateral_sigma_m) / std::max(exact, static_cast<float>(spec.nearest_m));
    const FloatVector3 ray{rays.x[i] + scale * static_cast<float>(jitter[0]),
                           rays.y[i] + scale * static_cast<float>(jitter[1]), 1.0f};
    const Met met = cast(view, objects, column, ray);
    float other = exact, step = 0.0f, depth = met.depth_m;
    for (const float there : around)
      if (std::abs(there - exact) > step) other = there, step = std::abs(there - exact);
    if (step > static_cast<float>(spec.edge_step_m)) {
      if (key.uniform(kEdgeIndex + index) < spec.edge_dropped_share) return 0;
      if (other < kNothing)
        depth += static_cast<float>(key.uniform(kEdgeIndex + index + 1)) * (other - depth);
    }
    if (!(depth < kNothing) || met.cosine < std::cos(static_cast<float>(spec.grazing_limit_rad))) return 0;
    const double z = static_cast<double>(depth),
                 angle = std::acos(std::min(1.0, static_cast<double>(met.cosine)));
    const double factor = 1.0 + (spec.corner_noise_factor - 1.0) * square(i) / corner;
    const double measured =
        z + unit.error_m(z) + spec.axial.sigma_m(z, angle) * factor * key.normal(0x40000000u + index);
    return measured >= spec.nearest_m && measured <= spec.farthest_m
               ? static_cast<std::uint16_t>(std::lround(1000.0 * measured))
               : std::uint16_t{0};
  }
};

double ms_of(const auto& render) {
  double best_s = 1e9;
  for (int round = 0; round < 3; ++round) {
    const auto start = std::chrono::steady_clock::now();
    for (int f = 0; f < kFrames; ++f) render(f);
    best_s =
        std::min(best_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return 1000.0 * best_s / kFrames;
}

}  // namespace

int main() {
  const DepthNoiseSpec noise;
  const DepthUnit unit = draw_depth_unit(noise, 5, 0);
  const DepthRenderer ours({}, noise, unit);
  const PlainRenderer plain(noise, unit);
  const RigidTransform pose = world_from_sensor_looking_at({0.0, 1.2, 2.5}, {0.0, 1.0, 0.0});
  const Motion walk = generated_motion(draw_person(3, 0, 1.7, 0.1), Activity::walking);
  std::vector<DepthScene> scenes(kFrames);
  for (int f = 0; f < kFrames; ++f) {
    append_room(scenes[static_cast<std::size_t>(f)], {}, {0.0, 0.0, 0.0});
    append_person(scenes[static_cast<std::size_t>(f)], walk(f / 30.0));
  }
  std::vector<std::uint16_t> image(plain.rays.x.size()), other(image.size());
  const auto key = [](int f) { return RandomStream{7, Purpose::depth_pixel, static_cast<std::uint64_t>(f)}; };
  const double vectors_ms =
      ms_of([&](int f) { ours.render(scenes[static_cast<std::size_t>(f)], pose, key(f), image); });
  const double loops_ms =
      ms_of([&](int f) { plain.render(scenes[static_cast<std::size_t>(f)], pose, key(f), other); });
  std::size_t both = 0, near = 0;
  for (std::size_t i = 0; i < image.size(); ++i)
    if (image[i] > 0 && other[i] > 0) {
      ++both;
      near += std::abs(image[i] - other[i]) <= 10;
    }
  std::printf(
      "vectors %.2f ms a frame, plain loops %.2f ms: ratio %.1f; %zu of %zu pixels are in both, %.1f %% of "
      "these within 1 cm\n",
      vectors_ms, loops_ms, loops_ms / vectors_ms, both, image.size(),
      100.0 * static_cast<double>(near) / static_cast<double>(both));
}
