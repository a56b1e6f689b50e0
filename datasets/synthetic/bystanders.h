// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "datasets/synthetic/motion.h"

namespace trilat {

inline constexpr std::uint64_t kMostBystanders = 2;

// Further persons of a take, drawn by seed and take: each stands 0.9 to 1.5 m from the centre or walks on a
// small circle whose middle is 1.3 to 1.5 m away, turned anyhow. The second is on the other side.
std::vector<Motion> bystander_motions(std::uint64_t seed, std::uint64_t take, std::uint64_t count,
                                      const Eigen::Vector3d& centre_in_world_m, double stature_mean_m,
                                      double stature_half_range_m);

}  // namespace trilat
