// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "datasets/base/words.h"

namespace trilat {

enum class Gradient : std::uint8_t {
  // eq. 17 as printed, erratum E7: the step shrinks by about unit / distance, and unless the distances are
  // equal it ends where sum(u f / d) = 0, which is not the minimum of F.
  printed,
  corrected,  // J^T f
};
template <>
inline constexpr std::array words<Gradient>{"printed", "corrected"};

enum class Damping : std::uint8_t {
  none,  // eq. 14: the plain step, one descent from the start
  lm,    // Levenberg and Marquardt, on both sides of the sensors' plane; corrected gradient only
};
template <>
inline constexpr std::array words<Damping>{"none", "lm"};

enum class StopRule : std::uint8_t {
  printed,    // eq. 19, erratum E8: F_k - F_{k-1} < threshold, true as soon as F falls
  objective,  // |F_k - F_{k-1}| < threshold
  step,       // |x_k - x_{k-1}| < step_tolerance
};
template <>
inline constexpr std::array words<StopRule>{"printed", "objective", "step"};

// The matrix that the step inverts.
enum class Curvature : std::uint8_t {
  gauss_newton,  // J^T J (eq. 14, which the paper calls Newton iteration: erratum E10)
  // Half the Hessian of F, J^T J + sum (1 - r/d) (I - u u^T), once Gauss-Newton predicts F well.
  newton,
};
template <>
inline constexpr std::array words<Curvature>{"gauss_newton", "newton"};

struct DescentOptions {
  Gradient gradient = Gradient::corrected;
  Damping damping = Damping::lm;
  StopRule stop = StopRule::step;
  Curvature curvature = Curvature::gauss_newton;
  double threshold_m2 = 1e-8;       // of printed and objective; the paper's C is in cm^2
  double step_tolerance_m = 1e-10;  // of step
  int max_iterations = 1000;
  // The length in which the printed gradient counts distances. The paper's figures are in centimetres; in
  // metres its step would be 100 times as long.
  double printed_unit_m = 0.01;
};

// A sentence that says how these options contradict each other; empty when they do not.
std::string contradiction_in(const DescentOptions& options);

}  // namespace trilat
