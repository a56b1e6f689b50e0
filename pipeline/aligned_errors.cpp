// SPDX-License-Identifier: MIT
#include "pipeline/aligned_errors.h"

namespace trilat {

TakeAlignments align_take(const SamplesFile& samples, std::size_t take, const Axes& axes,
                          const std::vector<AlignmentKind>& kinds) {
  std::vector<AlignmentSums> sums(axes.joints * axes.methods);
  stream_take(
      samples, take, axes, SampleColumns::positions,
      [&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot, const SampleView& view) {
        if (is_usable(view.status(slot)))
          sums[j * axes.methods + m].add(view.estimate(slot), view.truth(i, j));
      },
      [](const SampleBlock&) {});
  TakeAlignments result;
  for (AlignmentKind kind : kinds) {
    std::vector<Alignment> solved(axes.joints * axes.methods);
    for (std::size_t m = 0; m < axes.methods; ++m) {
      AlignmentSums whole;
      for (std::size_t j = 0; j < axes.joints; ++j) whole.merge(sums[j * axes.methods + m]);
      for (std::size_t j = 0; j < axes.joints; ++j)
        solved[j * axes.methods + m] =
            solve_alignment(kind == AlignmentKind::rigid ? whole : sums[j * axes.methods + m], kind);
    }
    result.push_back(std::move(solved));
  }
  return result;
}

AlignedError error_of(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot,
                      const std::vector<Alignment>& alignment) {
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  const SolveStatus status = view.status(slot);
  if (!is_usable(status)) return {status, none};
  const Alignment& a = alignment[j * view.axes.methods + m];
  if (a.status != AlignmentStatus::aligned) return {SolveStatus::not_solved, none};
  return {status, a.truth_from_estimate * view.estimate(slot) - view.truth(i, j)};
}

}  // namespace trilat
