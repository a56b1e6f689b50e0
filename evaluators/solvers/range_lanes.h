// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "evaluators/solvers/descent.h"

namespace trilat {

// Rows of doubles, one lane a problem, each row starting on a boundary of 64 bytes and filled up to a
// multiple of kLaneBlock lanes. Zero at first.
class AlignedRows {
 public:
  AlignedRows() = default;
  AlignedRows(std::size_t rows, std::size_t lanes);
  double* row(std::size_t r) { return data_.get() + r * stride_; }
  const double* row(std::size_t r) const { return data_.get() + r * stride_; }
  std::size_t stride() const { return stride_; }

  // x, y, z of rows that hold positions.
  Eigen::Vector3d position(std::size_t lane) const { return {row(0)[lane], row(1)[lane], row(2)[lane]}; }
  void set_position(std::size_t lane, const Eigen::Vector3d& x_m) {
    for (int axis = 0; axis < 3; ++axis) row(static_cast<std::size_t>(axis))[lane] = x_m[axis];
  }

 private:
  struct Free {
    void operator()(double* p) const;
  };
  std::unique_ptr<double[], Free> data_;
  std::size_t stride_ = 0;
};
inline constexpr std::size_t kLaneBlock = 8;  // lanes of the widest vector

// Problems of one rig side by side, all of which every sensor sees.
struct RangeLanes {
  std::vector<Eigen::Vector3d> sensor_m;  // world; 1 to kMaxSensors
  std::size_t count = 0;                  // lanes in use
  AlignedRows range_m;                    // a row a sensor
  AlignedRows position_m;                 // x, y, z: the start, then the end
  AlignedRows iterations;                 // steps tried
  std::vector<SolveStatus> status;

  RangeLanes(std::span<const Eigen::Vector3d> sensors_m, std::size_t lanes);
};

// descend() without damping in every lane, with the same bits, by the widest vectors this processor has: for
// sweeps, and for the equations as printed, which take hundreds of steps. InternalError for options with
// damping.
void descend(RangeLanes& lanes, const DescentOptions& options);

}  // namespace trilat
