// SPDX-License-Identifier: MIT
#include "pipeline/aligned_errors.h"

#include <cmath>

namespace trilat {
namespace {

// What the alignments of a take are made from, by joint and method.
struct TakeSums {
  std::vector<AlignmentSums> whole;
  std::vector<JointOffset> trained;
};

TakeSums sum_take(const SamplesFile& samples, std::size_t take, const Axes& axes,
                  std::uint64_t training_end) {
  TakeSums sums{std::vector<AlignmentSums>(axes.joints * axes.methods),
                std::vector<JointOffset>(axes.joints * axes.methods)};
  stream_take(
      samples, take, axes, SampleColumns::positions,
      [&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot, const SampleView& view) {
        if (!is_usable(view.status(slot))) return;
        const std::size_t k = j * axes.methods + m;
        sums.whole[k].add(view.estimate(slot), view.truth(i, j));
        if (view.block.first_instant + i < training_end && std::isfinite(view.heading_rad(i)))
          sums.trained[k].add(view.estimate(slot), view.truth(i, j), view.heading_rad(i));
      },
      [](const SampleBlock&) {});
  return sums;
}

}  // namespace

TakeAlignments align_take(const SamplesFile& samples, std::size_t take, const Axes& axes,
                          const std::vector<AlignmentKind>& kinds, double training_share) {
  const auto training_end = static_cast<std::uint64_t>(
      std::llround(training_share * static_cast<double>(samples.header().takes[take].instants)));
  const TakeSums sums = sum_take(samples, take, axes, training_end);
  TakeAlignments result;
  for (AlignmentKind kind : kinds) {
    std::vector<JointAlignment> solved(axes.joints * axes.methods);
    for (std::size_t m = 0; m < axes.methods; ++m) {
      AlignmentSums whole;
      for (std::size_t j = 0; j < axes.joints; ++j) whole.merge(sums.whole[j * axes.methods + m]);
      for (std::size_t j = 0; j < axes.joints; ++j) {
        const std::size_t k = j * axes.methods + m;
        solved[k].kind = kind;
        if (is_trained(kind)) solved[k].first_instant = training_end;
        if (kind == AlignmentKind::joint_offset)
          solved[k].offset = sums.trained[k];
        else
          solved[k].alignment = solve_alignment(kind == AlignmentKind::rigid ? whole : sums.whole[k], kind);
      }
    }
    result.push_back(std::move(solved));
  }
  return result;
}

AlignedError error_of(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot,
                      const std::vector<JointAlignment>& alignments) {
  const JointAlignment& a = alignments[j * view.axes.methods + m];
  AlignedError result;
  result.asked = view.block.first_instant + i >= a.first_instant;
  if (!result.asked) return result;
  const SolveStatus status = view.status(slot);
  if (!is_usable(status)) {
    result.status = status;
    return result;
  }
  const Eigen::Vector3d truth_m = view.truth(i, j);
  Eigen::Vector3d aligned_m = Eigen::Vector3d::Constant(kNaN);
  if (a.kind == AlignmentKind::joint_offset)
    aligned_m = a.offset.corrected(view.estimate(slot), view.heading_rad(i));
  else if (a.alignment.status == AlignmentStatus::aligned)
    aligned_m = a.alignment.truth_from_estimate * view.estimate(slot);
  if (!aligned_m.allFinite()) return result;
  result.status = status;
  result.error_m = aligned_m - truth_m;
  return result;
}

}  // namespace trilat
