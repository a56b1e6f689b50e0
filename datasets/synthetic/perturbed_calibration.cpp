// SPDX-License-Identifier: MIT
#include "datasets/synthetic/perturbed_calibration.h"

#include "datasets/base/philox.h"

namespace trilat {

Calibration perturbed(Calibration calibration, double sigma_m, double sigma_rad, std::uint64_t seed) {
  for (std::size_t s = 0; s < calibration.sensors.size(); ++s) {
    const RandomStream random{seed, Purpose::calibration_error, s};
    const Eigen::Vector3d turn =
        sigma_rad * Eigen::Vector3d(random.normal(0), random.normal(1), random.normal(2));
    SensorPose& pose = calibration.sensors[s];
    const double angle = turn.norm();
    if (angle > 0.0)
      pose.world_from_sensor.rotation =
          (Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) * pose.world_from_sensor.rotation)
              .normalized();
    pose.world_from_sensor.translation_m +=
        sigma_m * Eigen::Vector3d(random.normal(3), random.normal(4), random.normal(5));
    pose.position_sigma_m = sigma_m;
    pose.rotation_sigma_rad = sigma_rad;
  }
  calibration.method = "simulated truth, perturbed";
  return calibration;
}

}  // namespace trilat
