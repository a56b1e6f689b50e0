// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/method_pairs.h"

#include "pipeline/accuracy/statistics/take_statistics.h"

namespace trilat {
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

std::vector<double> paired_errors_m(const SamplesFile& samples, const std::string& condition,
                                    StatisticsLayout layout) {
  const Axes& axes = layout.axes;
  const std::size_t pairs = axes.methods * axes.methods;
  std::vector<SampleBlock> takes;
  for (std::size_t t = 0; t < samples.header().takes.size(); ++t)
    if (samples.header().takes[t].condition == condition)
      takes.push_back(samples.read(t, 0, samples.header().takes[t].instants, SampleColumns::positions));
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
