// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "evaluators/bodies/observed_body.h"
#include "evaluators/fusion/joint_observation.h"

namespace trilat {

// How equation 8 is read (erratum E6).
// printed: bones cross in camera x and y, metres, as if the lens were infinitely far away; depth is linear
//   along a bone; every two bones are compared. Its VectorProduct(x1, x2, y1, y2) = x1 y2 - x2 y1 is called
//   with (x, y, x, y): the names disagree, but by position it is a_x b_y - a_y b_x, the cross product that is
//   meant, so that the number is right.
// corrected: bones cross in the image (x / z, y / z); what is in front is decided on the viewing ray of the
//   crossing; bones that share a joint are not compared; a joint at z <= 0 is not there.
// Both take bones for lines: a joint beside a thick limb is not found. Bones that only touch do not cross.
enum class OcclusionVariant : std::uint8_t { printed, corrected };

// For every joint the number of crossings at which a bone that ends there lies behind another bone: a
// crossing counts for both ends of the farther bone, and for nobody when both are equally far. Bones without
// both ends are left out.
[[nodiscard]] std::array<int, kJointCount> count_occlusions(const ObservedBody& body,
                                                            OcclusionVariant variant);

// The paper's choice for one joint, among the sensors that see it: those without occlusion if there is one,
// else all with the fewest crossings. With fewer than `fewest` of them, all with the next larger number join,
// and so on: equals stay together, so that the order of the sensors does not matter and more than `fewest`
// may be chosen. `occlusions_of_sensor` has one number a sensor of the rig. InternalError beyond kMaxSensors.
[[nodiscard]] SensorMask select_unoccluded(std::span<const int> occlusions_of_sensor, SensorMask seen,
                                           int fewest = 1);

}  // namespace trilat
