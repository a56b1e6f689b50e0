// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "datasets/rig/depth_rays.h"
#include "datasets/synthetic/depth/depth_renderer.h"

namespace trilat {

// The depth renderer as one would first write it, in double precision: every ray against every surface, one
// pixel after another, standard library functions. It draws the same random numbers.
struct PlainHit {
  double depth_m = std::numeric_limits<double>::infinity();
  double cosine = 0.0;
};

inline void keep_nearer(PlainHit& best, double depth_m, double cosine) {
  if (depth_m > 0.0 && depth_m < best.depth_m) best = {depth_m, cosine};
}

inline void plain_sphere(PlainHit& best, const Eigen::Vector3d& centre, double radius,
                         const Eigen::Vector3d& ray) {
  const double b = ray.dot(centre), c = centre.squaredNorm() - radius * radius;
  const double h = b * b - ray.squaredNorm() * c;
  if (h <= 0.0) return;
  const double t = (b - std::sqrt(h)) / ray.squaredNorm();
  keep_nearer(best, t, (centre - t * ray).normalized().dot(ray.normalized()));
}

// Its side between the ends, and both end balls.
inline void plain_capsule(PlainHit& best, const SceneCapsule& capsule, const Eigen::Vector3d& ray) {
  plain_sphere(best, capsule.from_m, capsule.radius_m, ray);
  plain_sphere(best, capsule.to_m, capsule.radius_m, ray);
  const double length = (capsule.to_m - capsule.from_m).norm();
  const Eigen::Vector3d axis = (capsule.to_m - capsule.from_m) / length;
  const Eigen::Vector3d across = ray - axis.dot(ray) * axis;
  const Eigen::Vector3d start = -capsule.from_m + axis.dot(capsule.from_m) * axis;
  const double a = across.squaredNorm(), b = across.dot(start);
  const double h = b * b - a * (start.squaredNorm() - capsule.radius_m * capsule.radius_m);
  if (h <= 0.0 || a <= 0.0) return;
  const double t = (-b - std::sqrt(h)) / a;
  const double height = axis.dot(t * ray - capsule.from_m);
  if (height <= 0.0 || height >= length) return;
  keep_nearer(best, t, -(start + t * across).normalized().dot(ray.normalized()));
}

// The scene in the sensor's frame, a ray (x, y, 1).
inline PlainHit plain_cast(const DepthScene& scene, const Eigen::Vector3d& ray) {
  PlainHit best;
  for (const ScenePlane& plane : scene.planes)
    if (plane.offset_m < 0.0 && plane.normal.dot(ray) < 0.0)
      keep_nearer(best, plane.offset_m / plane.normal.dot(ray), -plane.normal.dot(ray.normalized()));
  for (const SceneSphere& sphere : scene.spheres) plain_sphere(best, sphere.centre_m, sphere.radius_m, ray);
  for (const SceneCapsule& capsule : scene.capsules) plain_capsule(best, capsule, ray);
  return best;
}

inline DepthScene scene_in_sensor(DepthScene scene, const RigidTransform& world_from_sensor) {
  const RigidTransform sensor_from_world = world_from_sensor.inverse();
  for (ScenePlane& plane : scene.planes) {
    plane.offset_m -= plane.normal.dot(world_from_sensor.translation_m);
    plane.normal = sensor_from_world.rotation * plane.normal;
  }
  for (SceneSphere& sphere : scene.spheres) sphere.centre_m = sensor_from_world * sphere.centre_m;
  for (SceneCapsule& capsule : scene.capsules) {
    capsule.from_m = sensor_from_world * capsule.from_m;
    capsule.to_m = sensor_from_world * capsule.to_m;
  }
  return scene;
}

class PlainDepthRenderer {
 public:
  PlainDepthRenderer(const DepthIntrinsics& intrinsics, const DepthNoiseSpec& noise, const DepthUnit& unit)
      : rays_(depth_rays(intrinsics)), noise_(noise), unit_(unit) {
    for (std::size_t i = 0; i < rays_.x.size(); ++i)
      if (radius(i) > corner_radius_) corner_radius_ = radius(i);
  }

  std::vector<std::uint16_t> render(const DepthScene& world, const RigidTransform& world_from_sensor,
                                    const RandomStream& key) const {
    const DepthScene scene = scene_in_sensor(world, world_from_sensor);
    std::vector<PlainHit> exact(rays_.x.size());
    for (std::size_t i = 0; i < exact.size(); ++i) exact[i] = plain_cast(scene, ray(i));
    std::vector<std::uint16_t> image(exact.size());
    for (std::size_t i = 0; i < image.size(); ++i) image[i] = measured_mm(scene, exact, key, i);
    return image;
  }

 private:
  Eigen::Vector3d ray(std::size_t i) const { return rays_.point_in_sensor_m(column(i), row(i), 1.0); }
  int column(std::size_t i) const {
    return static_cast<int>(i % static_cast<std::size_t>(rays_.intrinsics.width_px));
  }
  int row(std::size_t i) const {
    return static_cast<int>(i / static_cast<std::size_t>(rays_.intrinsics.width_px));
  }
  double radius(std::size_t i) const {
    return std::hypot(static_cast<double>(rays_.x[i]), static_cast<double>(rays_.y[i]));
  }

  static std::array<double, 4> uniforms(const RandomStream& key, std::uint32_t index) {
    const auto words =
        philox4x32_10({index, static_cast<std::uint32_t>(key.item),
                       static_cast<std::uint32_t>(key.item >> 32), static_cast<std::uint32_t>(key.purpose)},
                      {static_cast<std::uint32_t>(key.seed), static_cast<std::uint32_t>(key.seed >> 32)});
    std::array<double, 4> u{};
    for (std::size_t k = 0; k < 4; ++k) u[k] = (static_cast<double>(words[k] >> 9) + 0.5) * 0x1p-23;
    return u;
  }

  // The neighbour that differs most, and by how much.
  double step_at(const std::vector<PlainHit>& exact, std::size_t i, double& other_m) const {
    double step = 0.0;
    const auto look = [&](bool inside, std::size_t there) {
      if (!inside) return;
      const double by = std::abs(exact[there].depth_m - exact[i].depth_m);
      if (!(by > step)) return;
      step = by;
      other_m = exact[there].depth_m;
    };
    const auto width = static_cast<std::size_t>(rays_.intrinsics.width_px);
    look(column(i) > 0, i - 1);
    look(column(i) + 1 < rays_.intrinsics.width_px, i + 1);
    look(row(i) > 0, i - width);
    look(row(i) + 1 < rays_.intrinsics.height_px, i + width);
    return step;
  }

  std::uint16_t measured_mm(const DepthScene& scene, const std::vector<PlainHit>& exact,
                            const RandomStream& key, std::size_t i) const {
    if (!(radius(i) <= noise_.valid_radius)) return 0;
    constexpr double kTwoPi = 2.0 * std::numbers::pi;
    const auto u = uniforms(key, static_cast<std::uint32_t>(i));
    const double r0 = std::sqrt(-2.0 * std::log(u[0])), r1 = std::sqrt(-2.0 * std::log(u[2]));
    const double scale = noise_.lateral_sigma_m / std::max(exact[i].depth_m, noise_.nearest_m);
    const Eigen::Vector3d jitter(scale * r0 * std::cos(kTwoPi * u[1]), scale * r0 * std::sin(kTwoPi * u[1]),
                                 0.0);
    PlainHit hit = plain_cast(scene, ray(i) + jitter);
    double other_m = 0.0;
    if (step_at(exact, i, other_m) > noise_.edge_step_m) {
      const auto edge = uniforms(key, 0x80000000u + static_cast<std::uint32_t>(i));
      if (edge[0] < noise_.edge_dropped_share) return 0;
      if (std::isfinite(other_m)) hit.depth_m += edge[1] * (other_m - hit.depth_m);
    }
    if (!std::isfinite(hit.depth_m) || hit.cosine < std::cos(noise_.grazing_limit_rad)) return 0;
    const double z = hit.depth_m;
    const double corner = radius(i) / corner_radius_;
    const double sigma_m = noise_.axial.sigma_m(z, std::acos(std::min(1.0, hit.cosine))) *
                           (1.0 + (noise_.corner_noise_factor - 1.0) * corner * corner);
    const double bias_m =
        unit_.offset_m +
        unit_.wiggle_amplitude_m * std::sin(kTwoPi * z / unit_.wiggle_length_m + unit_.wiggle_phase_rad);
    const double measured = z + bias_m + sigma_m * r1 * std::cos(kTwoPi * u[3]);
    if (!(measured >= noise_.nearest_m && measured <= noise_.farthest_m)) return 0;
    return static_cast<std::uint16_t>(std::lround(1000.0 * measured));
  }

  DepthRays rays_;
  DepthNoiseSpec noise_;
  DepthUnit unit_;
  double corner_radius_ = 0.0;
};

}  // namespace trilat
