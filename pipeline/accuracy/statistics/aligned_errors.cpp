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

// All but sets of sensors that a family has several of.
std::vector<std::size_t> competitors_of(const Plan& plan) {
  std::vector<std::size_t> competitors;
  for (std::size_t m = 0; m < plan.methods.size(); ++m) {
    const MethodSpec& spec = plan.methods[m].spec;
    const auto others = std::ranges::count_if(
        plan.methods, [&](const Method& other) { return other.spec.family == spec.family; });
    if (spec.family.empty() || spec.sensors.size() <= 1 || others == 1) competitors.push_back(m);
  }
  return competitors;
}

// `each_sample` calls what it is given as visit_samples() does.
TakeAlignments align(std::uint64_t instants, const StatisticsLayout& layout, const auto& each_sample) {
  const Axes& axes = layout.axes;
  const std::vector<AlignmentKind>& kinds = layout.alignments;
  const std::uint64_t training_end = layout.training_end(instants);
  std::vector<AlignedSums> own(axes.joints * axes.methods), on_both = own, reference_on_both = own;
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
    result.push_back({solve_alignments(own, axes.joints, kind, training_end),
                      solve_alignments(on_both, axes.joints, kind, training_end),
                      solve_alignments(reference_on_both, axes.joints, kind, training_end)});
  return result;
}

}  // namespace

AlignmentTable solve_alignments(std::span<const AlignedSums> sums, std::size_t joints, AlignmentKind kind,
                                std::uint64_t training_end) {
  AlignmentTable solved(sums.size());
  const std::size_t columns = sums.size() / joints;
  for (std::size_t m = 0; m < columns; ++m) {
    AlignmentSums whole;
    for (std::size_t j = 0; j < joints; ++j) whole.merge(sums[j * columns + m].whole);
    for (std::size_t j = 0; j < joints; ++j) {
      const std::size_t k = j * columns + m;
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

std::uint64_t StatisticsLayout::block_instants(std::uint64_t instants) const {
  constexpr double kBlock_s = 5.0;
  constexpr std::uint64_t kMostBlocks = 12;
  const auto wanted = static_cast<std::uint64_t>(std::max(1LL, std::llround(kBlock_s * rate_hz)));
  return std::max(wanted, (instants + kMostBlocks - 1) / kMostBlocks);
}

std::uint64_t StatisticsLayout::training_end(std::uint64_t instants) const {
  if (std::ranges::none_of(alignments, is_trained)) return 0;
  return static_cast<std::uint64_t>(std::llround(training_share * static_cast<double>(instants)));
}

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
  layout.competitors = competitors_of(plan);
  const auto& kinds = layout.alignments;
  const auto none = std::ranges::find(kinds, AlignmentKind::none);
  if (none != kinds.end()) layout.body_alignment = static_cast<std::size_t>(none - kinds.begin());
  layout.rate_hz = plan.study.rate_hz;
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
