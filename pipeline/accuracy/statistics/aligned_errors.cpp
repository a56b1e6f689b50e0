// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/aligned_errors.h"

#include <algorithm>
#include <cmath>

#include "datasets/results/item_store.h"
#include "datasets/skeleton/skeleton.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/accuracy/statistics/take_statistics.h"

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

Axes axes_of(const Plan& plan) {
  const std::vector<std::string> groups = groups_of(plan);
  Axes axes;
  axes.joints = plan.joints.size();
  axes.methods = plan.methods.size();
  axes.alignments = plan.study.alignments.size();
  axes.groups = groups.size();
  axes.sets = plan.study.occluded_apart ? 2 : 1;
  for (const Joint joint : plan.joints) {
    const auto group = std::ranges::find(groups, table_group(joint));
    axes.group_of_joint.push_back(static_cast<std::size_t>(group - groups.begin()));
  }
  return axes;
}

// How many instants make one block: as the study wants it, or longer until all blocks fit into the memory.
std::uint64_t block_instants_of(const Plan& plan, const Axes& axes) {
  const std::uint64_t row_bytes =
      sizeof(double) * (axes.cells() * CellColumns::count + axes.methods * BodySumColumns::count);
  const std::uint64_t fit = std::max<std::uint64_t>({kBlockSumBytes / row_bytes, plan.takes.size(), 1});
  const std::uint64_t most = std::min(fit, std::max<std::uint64_t>(kMostBlocks, plan.takes.size()));
  StatisticsLayout layout;
  layout.block_instants =
      static_cast<std::uint64_t>(std::max(1LL, std::llround(plan.study.block_s * plan.study.rate_hz)));
  const auto rows = [&] {
    std::uint64_t sum = 0;
    for (const PlannedTake& take : plan.takes) sum += layout.blocks(take.instants);
    return sum;
  };
  while (rows() > most) layout.block_instants *= 2;
  return layout.block_instants;
}

// `each_sample` calls what it is given as visit_samples() does.
TakeAlignments align(std::uint64_t instants, const StatisticsLayout& layout, const auto& each_sample) {
  const Axes& axes = layout.axes;
  const std::vector<AlignmentKind>& kinds = layout.alignments;
  const bool any_is_trained = std::ranges::any_of(kinds, is_trained);
  const auto training_end =
      any_is_trained
          ? static_cast<std::uint64_t>(std::llround(layout.training_share * static_cast<double>(instants)))
          : 0;
  SumTable own(axes.joints * axes.methods), on_both = own, reference_on_both = own;
  each_sample([&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot, const SampleView& view) {
    const std::size_t k = j * axes.methods + m, reference_slot = view.slot(i, j, layout.reference);
    if (!is_usable(view.status(slot))) return;
    own[k].add(view, i, j, slot, training_end);
    if (!is_usable(view.status(reference_slot))) return;
    on_both[k].add(view, i, j, slot, training_end);
    reference_on_both[k].add(view, i, j, reference_slot, training_end);
  });
  TakeAlignments result;
  for (AlignmentKind kind : kinds)
    result.push_back({solve_table(own, axes, kind, training_end),
                      solve_table(on_both, axes, kind, training_end),
                      solve_table(reference_on_both, axes, kind, training_end)});
  return result;
}

}  // namespace

TakeAlignments align_take(const SamplesFile& samples, const StatisticsLayout& layout) {
  return align(samples.header().takes[0].instants, layout, [&](const auto& visit) {
    stream_take(samples, layout.axes, SampleColumns::positions, visit, [](const SampleBlock&) {});
  });
}

TakeAlignments align_take(const SampleBlock& samples, const StatisticsLayout& layout) {
  return align(samples.instants, layout,
               [&](const auto& visit) { visit_samples(samples, layout.axes, visit); });
}

std::vector<std::string> groups_of(const Plan& plan) {
  std::vector<std::string> groups;
  for (const Joint joint : plan.joints)
    if (const std::string group = table_group(joint); std::ranges::find(groups, group) == groups.end())
      groups.push_back(group);
  return groups;
}

StatisticsLayout statistics_layout(const Plan& plan) {
  StatisticsLayout layout;
  layout.axes = axes_of(plan);
  layout.alignments = plan.study.alignments;
  layout.training_share = plan.study.training_share;
  layout.reference = plan.reference;
  const auto& kinds = layout.alignments;
  const auto none = std::ranges::find(kinds, AlignmentKind::none);
  if (none != kinds.end()) layout.body_alignment = static_cast<std::size_t>(none - kinds.begin());
  layout.rate_hz = plan.study.rate_hz;
  layout.block_instants = block_instants_of(plan, layout.axes);
  for (const Bone& bone : kBones) {
    const auto from = std::ranges::find(plan.joints, bone.parent);
    const auto to = std::ranges::find(plan.joints, bone.child);
    if (from != plan.joints.end() && to != plan.joints.end())
      layout.bones.emplace_back(from - plan.joints.begin(), to - plan.joints.begin());
  }
  return layout;
}

namespace {

// By alignment, group and method, of all takes.
using Means = std::vector<Mean>;

// Errors of all methods over the samples that the layout's reference answers too.
void add_take(const SampleBlock& samples, const StatisticsLayout& layout, Means& means) {
  const Axes& axes = layout.axes;
  const TakeAlignments alignments = align_take(samples, layout);
  visit_samples(
      samples, axes,
      [&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot, const SampleView& view) {
        if (!is_usable(view.status(view.slot(i, j, layout.reference)))) return;
        for (std::size_t a = 0; a < alignments.size(); ++a) {
          const AlignedError e = error_of(view, i, j, m, slot, alignments[a].on_both);
          if (is_usable(e.status))
            means[(a * axes.groups + axes.group_of_joint[j]) * axes.methods + m].add(e.error_m.norm());
        }
      });
}

}  // namespace

std::vector<double> paired_errors_m(const std::filesystem::path& results, const std::string& condition,
                                    StatisticsLayout layout) {
  const Axes& axes = layout.axes;
  const std::size_t pairs = axes.methods * axes.methods;
  std::vector<SampleBlock> takes;
  for (const ResultTake& take : result_takes(results))
    if (take.shape.condition == condition && !take.folder.empty())
      takes.push_back(open_samples(take).read(0, 0, take.shape.instants, SampleColumns::positions));
  std::vector<double> paired_m(axes.alignments * pairs, 0.0);
  for (std::size_t with = 0; with < axes.methods; ++with) {
    layout.reference = with;
    Means means(axes.alignments * axes.groups * axes.methods);
    for (const SampleBlock& take : takes) add_take(take, layout, means);
    for (std::size_t k = 0; k < means.size(); ++k) {
      const std::size_t a = k / axes.methods / axes.groups, m = k % axes.methods;
      paired_m[a * pairs + m * axes.methods + with] += means[k].value() / static_cast<double>(axes.groups);
    }
  }
  return paired_m;
}

}  // namespace trilat
