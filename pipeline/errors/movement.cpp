// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <span>

#include "evaluators/solvers/point_estimate.h"
#include "pipeline/errors/condition_errors.h"
#include "pipeline/errors/take_errors.h"

namespace trilat {
namespace {

// The truth and one method's answers over a whole take, by instant and joint. What is no answer is NaN.
struct MethodSamples {
  std::vector<Eigen::Vector3d> truth_m, estimate_m;
  std::vector<float> heading_rad;
};

// Only a few thousand instants are in memory with all methods.
MethodSamples read_samples(const StoredTake& take, std::size_t method) {
  constexpr std::uint64_t kTogether = 4096;
  const std::size_t joints = take.head().joints.size(), methods = take.head().methods.size();
  MethodSamples all;
  for (std::uint64_t first = 0; first < take.head().instants; first += kTogether) {
    const SampleBlock block =
        take.read(0, first, std::min(kTogether, take.head().instants - first), SampleColumns::errors);
    all.heading_rad.insert(all.heading_rad.end(), block.heading_rad.begin(), block.heading_rad.end());
    for (std::size_t k = 0; k < block.instants * joints; ++k) {
      const std::size_t slot = k * methods + method;
      const bool answers = is_usable(static_cast<SolveStatus>(block.status[slot]));
      all.truth_m.emplace_back(&block.truth_m[3 * k]);
      all.estimate_m.push_back(
          answers
              ? Eigen::Vector3d(Eigen::Map<const Eigen::Vector3f>(&block.estimate_m[3 * slot]).cast<double>())
              : Eigen::Vector3d::Constant(kNaN));
    }
  }
  return all;
}

// Length of a weighted sum of the truth at an instant and `beside` instants before and behind; NaN where one
// of them is unknown.
double truth_difference_m(const MethodSamples& samples, std::size_t joints, std::uint64_t i, std::size_t j,
                          std::uint64_t beside, double before, double here, double behind) {
  if (i < beside || i + beside >= samples.heading_rad.size()) return kNaN;
  const auto at = [&](std::uint64_t k) { return samples.truth_m[k * joints + j]; };
  Eigen::Vector3d sum_m = before * at(i - beside) + behind * at(i + beside);
  sum_m += here * at(i);  // unknown there, nothing is asked
  return sum_m.norm();
}

struct ErrorAt {
  double acceleration_m_s2, error_m;
  std::size_t block;
};

// Adds the errors of one joint to its rows: the half with the larger acceleration is abrupt; of equal ones
// those that come first are calm.
void add_halves(std::vector<ErrorAt> errors, std::span<MovementRow> blocks) {
  std::ranges::stable_sort(errors, {}, &ErrorAt::acceleration_m_s2);
  for (std::size_t k = 0; k < errors.size(); ++k) {
    MovementRow& row = blocks[errors[k].block];
    const bool is_calm = 2 * k < errors.size();
    ++(is_calm ? row.calm : row.abrupt);
    (is_calm ? row.calm_m : row.abrupt_m) += errors[k].error_m;
  }
}

}  // namespace

std::vector<MovementRow> movement_of(const StoredTake& take, const TakeErrors& table, std::size_t method,
                                     double rate_hz) {
  constexpr double kBeside_s = 1.0 / 15.0;
  const auto beside = static_cast<std::uint64_t>(std::max(1LL, std::llround(kBeside_s * rate_hz)));
  const double step_s = static_cast<double>(beside) / rate_hz;
  const std::size_t joints = take.head().joints.size();
  const std::uint64_t instants = take.head().instants;
  const MethodSamples samples = read_samples(take, method);
  const std::uint64_t of_block = block_instants(instants, rate_hz);
  const std::size_t blocks = (instants + of_block - 1) / of_block;
  std::vector<MovementRow> rows(joints * blocks);
  for (std::size_t j = 0; j < joints; ++j) {
    const std::span<MovementRow> own = std::span(rows).subspan(j * blocks, blocks);
    for (std::size_t b = 0; b < blocks; ++b) {
      own[b].quantity = static_cast<std::uint32_t>(j);
      own[b].block = static_cast<std::uint32_t>(b);
    }
    const auto aligned = std::ranges::find_if(table.laid_over, [&](const AlignmentRow& row) {
      return row.quantity == j && row.method == method && row.alignment == 0;
    });
    std::vector<ErrorAt> errors;
    for (std::uint64_t i = 0; i < instants; ++i) {
      const double moved_m = truth_difference_m(samples, joints, i, j, 1, -1.0, 0.0, 1.0);
      if (std::isfinite(moved_m)) {
        ++own[i / of_block].speeds;
        own[i / of_block].speed_m_s += moved_m * rate_hz / 2.0;
      }
      if (aligned == table.laid_over.end() || i < aligned->first_instant) continue;
      const std::size_t k = i * joints + j;
      const double error_m =
          (aligned->aligned_m(samples.estimate_m[k], samples.heading_rad[i]) - samples.truth_m[k]).norm();
      const double changed_m = truth_difference_m(samples, joints, i, j, beside, 1.0, -2.0, 1.0);
      if (std::isfinite(error_m) && std::isfinite(changed_m))
        errors.push_back({changed_m / (step_s * step_s), error_m, i / of_block});
    }
    add_halves(std::move(errors), own);
  }
  return rows;
}

}  // namespace trilat
