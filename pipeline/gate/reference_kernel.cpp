// SPDX-License-Identifier: MIT
#include "pipeline/gate/reference_kernel.h"

#include <cmath>
#include <cstddef>

namespace trilat {
namespace {

constexpr int kSteps = 6;
constexpr std::size_t kTogether = 8;
using Lanes = double[kTogether];

// One step of eight problems, all of them at every line.
void step_together(const ReferenceProblem* p, Lanes (&x)[3]) {
  Lanes normal[6] = {}, right[3] = {};  // xx, yy, zz, yz, xz, xy
  for (int s = 0; s < 4; ++s)
    for (std::size_t l = 0; l < kTogether; ++l) {
      const double a = x[0][l] - p[l].sensor_m[s][0], b = x[1][l] - p[l].sensor_m[s][1],
                   c = x[2][l] - p[l].sensor_m[s][2];
      const double squared = a * a + b * b + c * c, distance = std::sqrt(squared);
      const double pull = (p[l].range_m[s] - distance) / distance;
      normal[0][l] += a * a / squared;
      normal[1][l] += b * b / squared;
      normal[2][l] += c * c / squared;
      normal[3][l] += b * c / squared;
      normal[4][l] += a * c / squared;
      normal[5][l] += a * b / squared;
      right[0][l] += a * pull;
      right[1][l] += b * pull;
      right[2][l] += c * pull;
    }
  for (std::size_t l = 0; l < kTogether; ++l) {
    const double xx = normal[0][l], yy = normal[1][l], zz = normal[2][l];
    const double yz = normal[3][l], xz = normal[4][l], xy = normal[5][l];
    const double cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
    const double cyy = xx * zz - xz * xz, cyz = xy * xz - xx * yz, czz = xx * yy - xy * xy;
    const double whole = xx * cxx + xy * cxy + xz * cxz;
    x[0][l] += (cxx * right[0][l] + cxy * right[1][l] + cxz * right[2][l]) / whole;
    x[1][l] += (cxy * right[0][l] + cyy * right[1][l] + cyz * right[2][l]) / whole;
    x[2][l] += (cxz * right[0][l] + cyz * right[1][l] + czz * right[2][l]) / whole;
  }
}

}  // namespace

double solve_reference(std::span<const ReferenceProblem> problems) {
  double sum = 0.0;
  for (std::size_t first = 0; first + kTogether <= problems.size(); first += kTogether) {
    Lanes x[3] = {};
    for (std::size_t l = 0; l < kTogether; ++l)
      for (const auto& sensor : problems[first + l].sensor_m)
        for (int i = 0; i < 3; ++i) x[i][l] += 0.25 * sensor[i];
    for (int k = 0; k < kSteps; ++k) step_together(&problems[first], x);
    for (const Lanes& axis : x)
      for (const double value : axis) sum += value;
  }
  return sum;
}

}  // namespace trilat
