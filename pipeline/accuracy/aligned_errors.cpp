// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/aligned_errors.h"

#include <cmath>

namespace trilat {
namespace {

// What the alignments of one joint and method are made from.
struct AlignedSums {
  AlignmentSums whole;
  JointOffset trained;
  void add(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t slot,
           std::uint64_t training_end) {
    whole.add(view.estimate(slot), view.truth(i, j));
    if (view.block.first_instant + i < training_end && std::isfinite(view.heading_rad(i)))
      trained.add(view.estimate(slot), view.truth(i, j), view.heading_rad(i));
  }
};
using SumTable = std::vector<AlignedSums>;  // joints x methods

AlignmentTable solve_table(const SumTable& sums, const Axes& axes, AlignmentKind kind,
                           std::uint64_t training_end) {
  AlignmentTable solved(axes.joints * axes.methods);
  for (std::size_t m = 0; m < axes.methods; ++m) {
    AlignmentSums whole;
    for (std::size_t j = 0; j < axes.joints; ++j) whole.merge(sums[j * axes.methods + m].whole);
    for (std::size_t j = 0; j < axes.joints; ++j) {
      const std::size_t k = j * axes.methods + m;
      solved[k].kind = kind;
      if (is_trained(kind)) solved[k].first_instant = training_end;
      if (kind == AlignmentKind::joint_offset)
        solved[k].offset = sums[k].trained;
      else
        solved[k].alignment = solve_alignment(kind == AlignmentKind::rigid ? whole : sums[k].whole, kind);
      const Eigen::Quaterniond& rotation = solved[k].alignment.truth_from_estimate.rotation;
      solved[k].turns = rotation.coeffs() != Eigen::Quaterniond::Identity().coeffs();
    }
  }
  return solved;
}

}  // namespace

TakeAlignments align_take(const SamplesFile& samples, std::size_t take, const StatisticsLayout& layout) {
  const Axes& axes = layout.axes;
  const std::vector<AlignmentKind>& kinds = layout.alignments;
  const bool any_is_trained = std::any_of(kinds.begin(), kinds.end(), is_trained);
  const auto instants = static_cast<double>(samples.header().takes[take].instants);
  const auto training_end =
      any_is_trained ? static_cast<std::uint64_t>(std::llround(layout.training_share * instants)) : 0;
  SumTable own(axes.joints * axes.methods), on_both = own, reference_on_both = own, complete = own,
                                            reference_complete = own;
  stream_take(
      samples, take, axes, SampleColumns::positions,
      [&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot, const SampleView& view) {
        const std::size_t k = j * axes.methods + m, reference_slot = view.slot(i, j, layout.reference);
        const std::size_t completed = view.completed_slot(i, j, m, layout),
                          reference = view.completed_slot(i, j, layout.reference, layout);
        if (is_usable(view.status(completed)) && is_usable(view.status(reference))) {
          complete[k].add(view, i, j, completed, training_end);
          reference_complete[k].add(view, i, j, reference, training_end);
        }
        if (!is_usable(view.status(slot))) return;
        own[k].add(view, i, j, slot, training_end);
        if (!is_usable(view.status(reference_slot))) return;
        on_both[k].add(view, i, j, slot, training_end);
        reference_on_both[k].add(view, i, j, reference_slot, training_end);
      },
      [](const SampleBlock&) {});
  TakeAlignments result;
  for (AlignmentKind kind : kinds)
    result.push_back({solve_table(own, axes, kind, training_end),
                      solve_table(on_both, axes, kind, training_end),
                      solve_table(reference_on_both, axes, kind, training_end),
                      {},
                      {}});
  result.front().complete = solve_table(complete, axes, kinds.front(), training_end);
  result.front().reference_complete = solve_table(reference_complete, axes, kinds.front(), training_end);
  return result;
}

}  // namespace trilat
