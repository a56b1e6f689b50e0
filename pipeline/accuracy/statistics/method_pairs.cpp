// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/method_pairs.h"

#include "pipeline/accuracy/statistics/take_statistics.h"

namespace trilat {
namespace {

// By group and method, of all takes.
using Means = std::vector<Mean>;

// Errors of all methods over the samples that the layout's reference answers too.
void add_take(const SamplesFile& samples, std::size_t take, const StatisticsLayout& layout, Means& means) {
  const Axes& axes = layout.axes;
  const KindAlignments alignments = align_take(samples, take, layout).front();
  stream_take(
      samples, take, axes, SampleColumns::positions,
      [&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot, const SampleView& view) {
        const AlignedError e = error_of(view, i, j, m, slot, alignments.on_both);
        if (is_usable(e.status) && is_usable(view.status(view.slot(i, j, layout.reference))))
          means[axes.group_of_joint[j] * axes.methods + m].add(e.error_m.norm());
      },
      [](const SampleBlock&) {});
}

}  // namespace

std::vector<double> paired_errors_m(const SamplesFile& samples, const std::string& condition,
                                    StatisticsLayout layout) {
  const Axes& axes = layout.axes;
  layout.alignments.resize(1);
  std::vector<double> paired_m(axes.methods * axes.methods, 0.0);
  for (std::size_t with = 0; with < axes.methods; ++with) {
    layout.reference = with;
    Means means(axes.groups * axes.methods);
    for (std::size_t t = 0; t < samples.header().takes.size(); ++t)
      if (samples.header().takes[t].condition == condition) add_take(samples, t, layout, means);
    for (std::size_t k = 0; k < means.size(); ++k)
      paired_m[k % axes.methods * axes.methods + with] += means[k].value() / static_cast<double>(axes.groups);
  }
  return paired_m;
}

}  // namespace trilat
