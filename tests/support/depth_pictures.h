// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "datasets/base/philox.h"
#include "datasets/rig/depth_rays.h"

namespace trilat {

// Simple things in the sensor's frame, metres, and the exact picture of them. For tests and benchmarks.
struct PictureBall {
  Eigen::Vector3d centre;
  double radius_m;
};
struct PictureDisc {
  Eigen::Vector3d centre;
  Eigen::Vector3d normal;
  double radius_m;
};
struct PictureStick {  // a cylinder without caps
  Eigen::Vector3d from;
  Eigen::Vector3d to;
  double radius_m;
};
struct PicturePlane {  // normal . point = offset
  Eigen::Vector3d normal;
  double offset_m;
};
struct PictureScene {
  std::vector<PictureBall> balls;
  std::vector<PictureDisc> discs;
  std::vector<PictureStick> sticks;
  std::vector<PicturePlane> planes;
};

struct RayHit {
  double depth_m = std::numeric_limits<double>::infinity();
  double cosine = 0.0;  // between ray and surface normal

  void nearer(double t, const Eigen::Vector3d& normal, const Eigen::Vector3d& ray) {
    if (!(t > 0.0) || t >= depth_m) return;
    depth_m = t;
    cosine = std::abs(normal.dot(ray)) / ray.norm();
  }
};

// The first thing a ray (x, y, 1) meets.
inline RayHit first_hit(const PictureScene& scene, const Eigen::Vector3d& ray) {
  RayHit hit;
  for (const auto& [centre, radius_m] : scene.balls) {
    const double a = ray.squaredNorm(), b = ray.dot(centre);
    const double under = b * b - a * (centre.squaredNorm() - radius_m * radius_m);
    if (under < 0.0) continue;
    const double t = (b - std::sqrt(under)) / a;
    hit.nearer(t, (t * ray - centre) / radius_m, ray);
  }
  for (const auto& [centre, normal, radius_m] : scene.discs) {
    const double t = normal.dot(centre) / normal.dot(ray);
    if ((t * ray - centre).norm() <= radius_m) hit.nearer(t, normal, ray);
  }
  for (const auto& [from, to, radius_m] : scene.sticks) {
    const Eigen::Vector3d axis = (to - from).normalized();
    const Eigen::Vector3d d = ray - axis * axis.dot(ray), f = from - axis * axis.dot(from);
    const double a = d.squaredNorm(), b = d.dot(f);
    const double under = b * b - a * (f.squaredNorm() - radius_m * radius_m);
    if (under < 0.0 || a == 0.0) continue;
    const double t = (b - std::sqrt(under)) / a;
    const double along_m = axis.dot(t * ray - from);
    if (along_m >= 0.0 && along_m <= (to - from).norm()) hit.nearer(t, (t * d - f) / radius_m, ray);
  }
  for (const auto& [normal, offset_m] : scene.planes) hit.nearer(offset_m / normal.dot(ray), normal, ray);
  return hit;
}

// A depth picture with its own pixels.
struct DepthPicture {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint16_t> depth_mm;

  DepthImageView view() const { return {width_px, height_px, depth_mm}; }
  std::uint16_t& at(int column, int row) {
    return depth_mm[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_px) +
                    static_cast<std::size_t>(column)];
  }
};

// Rounded to millimetres; 0 beyond 8 m. With noise: Gaussian along z, the same for the same item.
inline DepthPicture picture_of(const PictureScene& scene, const DepthRays& rays,
                               const AxialNoise* noise = nullptr, std::uint64_t item = 0) {
  const RandomStream random{17, Purpose::test, item};
  const int width_px = rays.intrinsics.width_px;
  DepthPicture picture{width_px, rays.intrinsics.height_px, std::vector<std::uint16_t>(rays.x.size())};
  for (std::size_t i = 0; i < rays.x.size(); ++i) {
    const Eigen::Vector3d ray(static_cast<double>(rays.x[i]), static_cast<double>(rays.y[i]), 1.0);
    if (!ray.allFinite()) continue;
    const RayHit hit = first_hit(scene, ray);
    if (!(hit.depth_m < 8.0)) continue;
    double depth_m = hit.depth_m;
    if (noise) {
      const double angle_rad = std::acos(std::min(1.0, hit.cosine));
      if (angle_rad > 1.309) continue;  // 75 degrees: nothing comes back
      depth_m += noise->sigma_m(depth_m, angle_rad) * random.normal(static_cast<std::uint32_t>(i));
    }
    picture.depth_mm[i] = static_cast<std::uint16_t>(std::lround(1000.0 * std::max(0.0, depth_m)));
  }
  return picture;
}

}  // namespace trilat
