// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "datasets/base/document.h"

namespace trilat {

// The samples of a take that a row sums: all of them, or those in which a sensor sees the joint occluded.
enum class Subset : std::uint8_t { all, occluded };
inline constexpr std::array kSubsetNames{"all", "occluded"};

// Measure that a row of errors sums, in SI units. Each is the mean of the row's sum over its n.
enum class Measure : std::uint8_t {
  distance,  // of estimate and truth after alignment
  x,         // estimate - truth after alignment, along the world's axes
  y,
  z,
  mpjpe,              // mean distance of a body's joints, where every joint that has a truth is answered
  pa_mpjpe,           // the same after rotation, translation and scale of each instant
  bone,               // standard deviation of a bone's length over the take, before alignment
  jerk,               // length of the jerk, before alignment
  angle,              // estimate - truth
  true_angle,         // at the instants of `angle`
  motion_range,       // largest less smallest angle of a take, at the same instants
  true_motion_range,  // that of the truth
  range,              // along the ray of a sensor that is left out: how much farther than the sensor sees
  bearing             // distance from the ray
};
inline constexpr std::array kMeasureNames{
    "distance", "x",      "y",     "z",          "mpjpe",        "pa_mpjpe",
    "bone",     "jerk",   "angle", "true_angle", "motion_range", "true_motion_range",
    "range",    "bearing"};

// Errors of one method in one block of time (five seconds; a twelfth of the take where that is longer), or
// over the whole take in block 0: sums over samples. Quantities, methods and alignments are meant by their
// places in the take's lists; the number behind the last method is the truth, that behind the last alignment
// is before any.
struct ErrorSums {
  std::uint32_t block = 0, quantity = 0, method = 0, alignment = 0, subset = 0, measure = 0, n = 0;
  double sum = 0.0, sum_abs = 0.0, sum_squares = 0.0, largest = 0.0;  // largest: magnitude

  void add(double value) {
    ++n;
    sum += value;
    sum_abs += std::abs(value);
    sum_squares += value * value;
    largest = std::max(largest, std::abs(value));
  }
  void add(const ErrorSums& more) {
    n += more.n;
    sum += more.sum;
    sum_abs += more.sum_abs;
    sum_squares += more.sum_squares;
    largest = std::max(largest, more.largest);
  }
  bool is(Measure m) const { return measure == static_cast<std::uint32_t>(m); }
  static void fields(auto& self, auto&& f) {
    f("block", self.block, "quantity", self.quantity, "method", self.method, "alignment", self.alignment,
      "subset", self.subset, "measure", self.measure, "n", self.n, "sum", self.sum, "sum_abs", self.sum_abs,
      "sum_squares", self.sum_squares, "largest", self.largest);
  }
};

inline constexpr std::size_t kMaxStatuses = 16;

// How the samples of one joint and method ended that have a truth, over the whole take. `test`: 0 where
// trained alignments learn, 1 in the rest.
struct EndedRow {
  std::uint32_t quantity = 0, method = 0, subset = 0, test = 0, iterations = 0;
  std::array<std::uint32_t, kMaxStatuses> statuses{};

  std::uint32_t asked() const {
    std::uint32_t sum = 0;
    for (const std::uint32_t n : statuses) sum += n;
    return sum;
  }
  static void fields(auto& self, auto&& f) {
    f("quantity", self.quantity, "method", self.method, "subset", self.subset, "test", self.test,
      "iterations", self.iterations, "statuses", self.statuses);
  }
};

// Distances over the whole take: the next `bins` bins of the table are this row's.
struct HistogramRow {
  std::uint32_t quantity = 0, method = 0, alignment = 0, subset = 0, bins = 0;

  static void fields(auto& self, auto&& f) {
    f("quantity", self.quantity, "method", self.method, "alignment", self.alignment, "subset", self.subset,
      "bins", self.bins);
  }
};
// Number of distances in one bin: of a millimetre each up to two metres, then each longer by half a per cent
// than the one before; the last bin holds all that are longer.
struct BinRow {
  std::uint32_t bin = 0, n = 0;

  static void fields(auto& self, auto&& f) { f("bin", self.bin, "n", self.n); }
};
inline constexpr double kBin_m = 0.001;
inline constexpr std::uint32_t kFineBins = 2000, kLastBin = 3400;  // the last one from 2.15 km on
std::uint32_t bin_of(double length_m);
double bin_starts_at_m(std::uint32_t bin);

// How one method's estimates of a joint are laid over the truth, learnt from all its answers, and for the
// kinds that learn on a part of the take from those: truth = rotation * estimate + shift, where rotation is
// w, x, y, z; of `joint_offset` shift is - world_from_body(heading) * offset, and offset_m in the body's own
// frame. Instants before `first_instant` were learnt from and are not asked. NaN: no alignment was found.
struct AlignmentRow {
  std::uint32_t quantity = 0, method = 0, alignment = 0, first_instant = 0;
  std::array<double, 4> rotation{1.0, 0.0, 0.0, 0.0};
  std::array<double, 3> shift_m{}, offset_m{};

  Eigen::Vector3d aligned_m(const Eigen::Vector3d& estimate_m, double heading_rad) const {
    const Eigen::Quaterniond turn(rotation[0], rotation[1], rotation[2], rotation[3]);
    const Eigen::Map<const Eigen::Vector3d> shift(shift_m.data()), offset(offset_m.data());
    const Eigen::Vector3d moved_m = turn * estimate_m + shift;
    return offset.isZero(0.0) ? moved_m
                              : moved_m - Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitY()) * offset;
  }
  static void fields(auto& self, auto&& f) {
    f("quantity", self.quantity, "method", self.method, "alignment", self.alignment, "first_instant",
      self.first_instant, "rotation", self.rotation, "shift_m", self.shift_m, "offset_m", self.offset_m);
  }
};

// The errors of one take, of which every number of a study is made. Rows without samples are left out.
struct TakeErrors {
  std::string settings_sha256;          // of what decides them, beside the samples
  std::vector<std::string> alignments;  // in the order of the study
  std::vector<std::string> quantities;  // the joints of each track, the whole body (""), angles
  std::vector<AlignmentRow> laid_over;
  std::vector<ErrorSums> sums;
  std::vector<EndedRow> ended;
  std::vector<HistogramRow> histograms;
  std::vector<BinRow> bins;
};

}  // namespace trilat
