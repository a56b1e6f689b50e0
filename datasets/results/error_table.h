// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "datasets/base/described.h"

namespace trilat {

// The samples of a take that a row sums: all of them, or those in which a sensor sees the joint occluded.
enum class Subset : std::uint8_t { all, occluded };
inline constexpr std::array kSubsetNames{"all", "occluded"};

inline constexpr std::size_t kMostStatuses = 16;

// The errors of one method in one block of time (five seconds; a twelfth of the take where that is longer):
// sums over samples. Quantities are the joints of the first track, then those of the next. All numbers of a
// row are u32 or f64; blocks, quantities, methods, alignments and statuses are meant by their places in the
// take's lists.
struct ErrorRow {
  std::uint32_t block = 0, quantity = 0, method = 0, alignment = 0, subset = 0;
  std::uint32_t answered = 0;
  std::array<std::uint32_t, kMostStatuses> statuses{};  // how all that is asked ended
  std::uint32_t iterations = 0;                         // of all that is asked
  // Of the answered: estimate - truth after alignment, its length, squares and parts along the world's axes.
  double length_m = 0.0, length_m2 = 0.0, largest_m = 0.0;
  std::array<double, 3> error_m{}, error_m2{}, absolute_m{}, largest_axis_m{};

  std::uint32_t asked() const {
    std::uint32_t sum = 0;
    for (const std::uint32_t n : statuses) sum += n;
    return sum;
  }
  TRILAT_FIELDS(block, quantity, method, alignment, subset, answered, statuses, iterations, length_m,
                length_m2, largest_m, error_m, error_m2, absolute_m, largest_axis_m)
};

// Lengths of the errors of two methods on the samples that both answer, each aligned on just these.
struct PairRow {
  std::uint32_t block = 0, quantity = 0, first = 0, second = 0, alignment = 0, subset = 0;
  std::uint32_t n = 0;
  double first_m = 0.0, second_m = 0.0;

  TRILAT_FIELDS(block, quantity, first, second, alignment, subset, n, first_m, second_m)
};

// Lengths of errors over the whole take, of all samples and of the occluded: the next `bins` bins of the
// table are this row's.
struct HistogramRow {
  std::uint32_t quantity = 0, method = 0, alignment = 0, subset = 0, bins = 0;

  TRILAT_FIELDS(quantity, method, alignment, subset, bins)
};
// So many lengths in one bin: of a millimetre each up to two metres, then each longer by half a per cent than
// the one before; the last bin holds all that are longer.
struct BinRow {
  std::uint32_t bin = 0, n = 0;

  TRILAT_FIELDS(bin, n)
};
inline constexpr double kBin_m = 0.001;
inline constexpr std::uint32_t kFineBins = 2000, kLastBin = 3400;  // the last one from 2.15 km on
std::uint32_t bin_of(double length_m);
double bin_starts_at_m(std::uint32_t bin);

// Whole bodies of a method, at the instants at which it and `with` answer every joint that has a truth: sums
// of the mean distance of their joints, after the body alignment and after one of each instant's own. `with`
// is the method itself for all that it answers.
struct BodyRow {
  std::uint32_t block = 0, method = 0, with = 0;
  std::uint32_t n = 0, pa_n = 0;
  double mpjpe_m = 0.0, pa_mpjpe_m = 0.0;

  TRILAT_FIELDS(block, method, with, n, pa_n, mpjpe_m, pa_mpjpe_m)
};

// How a method's estimates hang together over the whole take, before any alignment: standard deviations of
// the lengths of bones, and lengths of the jerk, summed.
struct ShapeRow {
  std::uint32_t method = 0, bones = 0, jerks = 0;
  double bone_sd_m = 0.0, jerk_m_s3 = 0.0;

  TRILAT_FIELDS(method, bones, jerks, bone_sd_m, jerk_m_s3)
};

// How the truth of a joint moves: sums over the whole take.
struct TruthRow {
  std::uint32_t quantity = 0, jerks = 0;
  double jerk_m_s3 = 0.0;

  TRILAT_FIELDS(quantity, jerks, jerk_m_s3)
};

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
  TRILAT_FIELDS(quantity, method, alignment, first_instant, rotation, shift_m, offset_m)
};

// The table of errors of one take. Every number of a study's tables is a sum over some of its rows. Rows
// without samples are left out; the order is that of their first columns, `block` last.
struct ErrorTable {
  std::string settings_sha256;          // of what decides it, beside the samples
  std::vector<std::string> alignments;  // in the order of the study
  std::uint32_t body_alignment = 0;
  std::vector<AlignmentRow> laid_over;
  std::vector<ErrorRow> errors;
  std::vector<PairRow> pairs;  // first < second
  std::vector<HistogramRow> histograms;
  std::vector<BinRow> bins;
  std::vector<BodyRow> bodies;
  std::vector<ShapeRow> shapes;
  std::vector<TruthRow> truth;
};

}  // namespace trilat
