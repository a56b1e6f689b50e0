// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/take_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "evaluators/metrics/body_metrics.h"

namespace trilat {
namespace {

constexpr std::uint64_t kWindow = 512;  // instants that are read together
constexpr std::uint64_t kMargin = 2;    // and on either side, for differences in time

// Of the right sizes, without any samples.
TakeStatistics empty_statistics(const StatisticsLayout& layout, std::uint64_t instants) {
  const Axes& axes = layout.axes;
  const auto rows = static_cast<Eigen::Index>(layout.blocks(instants));
  TakeStatistics empty;
  empty.sums.resize(axes.cells());
  empty.cells = RowMatrix::Zero(rows, static_cast<Eigen::Index>(axes.cells() * CellColumns::count));
  empty.bodies = RowMatrix::Zero(rows, static_cast<Eigen::Index>(axes.methods * BodySumColumns::count));
  empty.of_joint.resize(axes.sets * axes.joints * axes.methods);
  empty.of_method.resize(axes.methods);
  empty.truth_speed_m_s.resize(axes.groups);
  return empty;
}

class TakeGatherer {
 public:
  TakeGatherer(const StatisticsLayout& layout, const TakeAlignments& alignments, std::uint64_t instants)
      : layout_(layout),
        axes_(layout.axes),
        alignments_(alignments),
        result_(empty_statistics(layout, instants)),
        block_instants_(layout.block_instants(instants)),
        lengths_(axes_.methods * layout.bones.size()),
        by_speed_(axes_.joints * axes_.methods) {}

  // The instants [first, end) of the view; those around them are only looked at.
  void add(const SampleView& view, std::uint64_t first, std::uint64_t end) {
    for (std::uint64_t i = first; i < end; ++i) {
      block_ = (view.block.first_instant + i) / block_instants_;
      for (std::size_t j = 0; j < axes_.joints; ++j) {
        if (!view.truth(i, j).allFinite()) continue;
        add_truth(view, i, j);
        for (std::size_t a = 0; a < axes_.alignments; ++a) add_errors(view, i, j, a);
      }
      for (std::size_t m = 0; m < axes_.methods; ++m) add_body(view, i, m);
    }
  }

  TakeStatistics finish() {
    for (std::size_t k = 0; k < lengths_.size(); ++k) {
      if (lengths_[k].count() < 2) continue;
      TakeBodies& bodies = result_.of_method[k / layout_.bones.size()];
      ++bodies.bones;
      bodies.bone_sd_m.add(lengths_[k].standard_deviation_m());
    }
    for (std::size_t k = 0; k < by_speed_.size(); ++k) split_by_speed(by_speed_[k], result_.of_joint[k]);
    return std::move(result_);
  }

 private:
  // Distances of what one method answered of one joint, by the joint's speed.
  static constexpr double kSpeedBin_m_s = 0.02;
  using BySpeed = std::array<Mean, 256>;  // the last one holds all that is faster

  // At the bin in which the samples are halved.
  static void split_by_speed(const BySpeed& bins, JointSums& sums) {
    std::uint64_t all = 0, slower = 0;
    for (const Mean& bin : bins) all += bin.n;
    for (const Mean& bin : bins) {
      (2 * slower < all ? sums.slow_m : sums.fast_m).merge(bin);
      slower += bin.n;
    }
  }

  void add_speed(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t m, double distance_m) {
    if (!has_truth(view, i, j, 1, 1)) return;
    const double speed_m_s = (view.truth(i + 1, j) - view.truth(i - 1, j)).norm() * layout_.rate_hz / 2.0;
    BySpeed& bins = by_speed_[j * axes_.methods + m];
    bins[std::min(bins.size() - 1, static_cast<std::size_t>(speed_m_s / kSpeedBin_m_s))].add(distance_m);
  }

  // Whether the truth is known at the instants from i - before to i + behind.
  bool has_truth(const SampleView& view, std::uint64_t i, std::size_t j, std::uint64_t before,
                 std::uint64_t behind) const {
    if (i < before || i + behind >= view.block.instants) return false;
    for (std::uint64_t k = i - before; k <= i + behind; ++k)
      if (!view.truth(k, j).allFinite()) return false;
    return true;
  }

  void add_truth(const SampleView& view, std::uint64_t i, std::size_t j) {
    const auto truth_m = [&](std::uint64_t k) { return view.truth(k, j); };
    if (has_truth(view, i, j, 1, 1))
      result_.truth_speed_m_s[axes_.group_of_joint[j]].add((truth_m(i + 1) - truth_m(i - 1)).norm() *
                                                           layout_.rate_hz / 2.0);
    if (has_truth(view, i, j, 1, 2))
      result_.truth_jerk_m_s3.add(
          jerk_m_s3(truth_m(i - 1), truth_m(i), truth_m(i + 1), truth_m(i + 2), layout_.rate_hz));
  }

  void add_errors(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t a) {
    const std::size_t sets = view.sets(i, j);
    for (std::size_t m = 0; m < axes_.methods; ++m) {
      const std::size_t slot = view.slot(i, j, m);
      const AlignedError e = error_of(view, i, j, m, slot, alignments_[a].own);
      if (!e.asked) return;
      const Pair pair = pair_of(view, i, j, m, a);
      if (a == 0) add_joint(e, pair, pair_of_any(view, i, j, m, pair), sets, j * axes_.methods + m);
      for (std::size_t set = 0; set < sets; ++set)
        add_sums(view.block, slot, e, result_.sums[axes_.cell(set, axes_.group_of_joint[j], m, a)]);
      if (!is_usable(e.status)) continue;
      const double distance_m = e.error_m.norm();
      if (a == 0) add_speed(view, i, j, m, distance_m);
      for (std::size_t set = 0; set < sets; ++set) {
        const std::size_t cell = axes_.cell(set, axes_.group_of_joint[j], m, a);
        double* sums = &result_.cells(static_cast<Eigen::Index>(block_),
                                      static_cast<Eigen::Index>(cell * CellColumns::count));
        sums[CellColumns::distance] += distance_m;
        sums[CellColumns::answered] += 1.0;
        if (pair.both) {
          sums[CellColumns::difference] += pair.method_m - pair.reference_m;
          sums[CellColumns::both] += 1.0;
          sums[CellColumns::reference] += pair.reference_m;
        }
      }
    }
  }

  // The distances of a method and the reference where both answer, aligned on such samples.
  struct Pair {
    bool both = false;
    double method_m = 0.0, reference_m = 0.0;
    void add_to(PairedSums& sums) const {
      if (!both) return;
      sums.method_m.add(method_m);
      sums.reference_m.add(reference_m);
    }
  };

  void add_joint(const AlignedError& e, const Pair& both, const Pair& complete, std::size_t sets,
                 std::size_t joint_and_method) {
    for (std::size_t set = 0; set < sets; ++set) {
      JointSums& sums = result_.of_joint[set * axes_.joints * axes_.methods + joint_and_method];
      ++sums.asked;
      if (is_usable(e.status)) sums.distance_m.add(e.error_m.norm());
      both.add_to(sums.both);
      complete.add_to(sums.complete);
    }
  }

  static void add_sums(const SampleBlock& block, std::size_t slot, const AlignedError& e, CellSums& sums) {
    sums.errors.add(e.status, e.error_m);
    sums.iterations.add(block.iterations[slot]);
  }

  Pair pair_of(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t m, std::size_t a) const {
    const std::size_t k = j * axes_.methods + m;
    return pair_of(
        error_of(view, i, j, view.slot(i, j, m), alignments_[a].on_both[k]),
        error_of(view, i, j, view.slot(i, j, layout_.reference), alignments_[a].reference_on_both[k]));
  }
  // Where one of the two is silent, the other's error stands for both, under the first alignment: silence
  // neither wins nor loses.
  Pair pair_of_any(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t m,
                   const Pair& both) const {
    if (both.both) return both;
    for (const std::size_t of : {m, layout_.reference}) {
      const AlignedError e = error_of(view, i, j, of, view.slot(i, j, of), alignments_[0].own);
      if (is_usable(e.status)) return {true, e.error_m.norm(), e.error_m.norm()};
    }
    return {};
  }
  static Pair pair_of(const AlignedError& method, const AlignedError& reference) {
    if (!is_usable(method.status) || !is_usable(reference.status)) return {};
    return {true, method.error_m.norm(), reference.error_m.norm()};
  }

  void add_body(const SampleView& view, std::uint64_t i, std::size_t m) {
    estimate_m_.clear();
    aligned_m_.clear();
    truth_m_.clear();
    TakeBodies& bodies = result_.of_method[m];
    std::size_t asked = 0;
    for (std::size_t j = 0; j < axes_.joints; ++j) {
      if (!view.truth(i, j).allFinite()) continue;
      const std::size_t slot = view.slot(i, j, m);
      const AlignedError e = error_of(view, i, j, m, slot, alignments_[layout_.body_alignment].own);
      if (!e.asked) return;
      ++asked;
      if (is_usable(view.status(slot))) add_jerk(view, i, j, m);
      if (!is_usable(e.status)) continue;
      for (std::size_t r = 0; r < kPckRadii_m.size(); ++r)
        bodies.within[r] += e.error_m.norm() <= kPckRadii_m[r];
      estimate_m_.push_back(view.estimate(slot));
      truth_m_.push_back(view.truth(i, j));
      aligned_m_.push_back(e.error_m + view.truth(i, j));
    }
    bodies.joints += asked;
    add_bones(view, i, m);
    if (asked == 0 || truth_m_.size() < asked) return;
    double* sums = &result_.bodies(static_cast<Eigen::Index>(block_),
                                   static_cast<Eigen::Index>(m * BodySumColumns::count));
    sums[BodySumColumns::mpjpe] += mpjpe_m(aligned_m_, truth_m_);
    sums[BodySumColumns::whole] += 1.0;
    const double pa_m = pa_mpjpe_m(estimate_m_, truth_m_);
    if (!std::isfinite(pa_m)) return;
    sums[BodySumColumns::pa_mpjpe] += pa_m;
    sums[BodySumColumns::pa_whole] += 1.0;
  }

  void add_jerk(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t m) {
    if (i < 1 || i + 2 >= view.block.instants) return;
    for (std::uint64_t k = i - 1; k <= i + 2; ++k)
      if (!is_usable(view.status(view.slot(k, j, m)))) return;
    const auto at = [&](std::uint64_t k) { return view.estimate(view.slot(k, j, m)); };
    result_.of_method[m].jerk_m_s3.add(jerk_m_s3(at(i - 1), at(i), at(i + 1), at(i + 2), layout_.rate_hz));
  }

  void add_bones(const SampleView& view, std::uint64_t i, std::size_t m) {
    for (std::size_t b = 0; b < layout_.bones.size(); ++b) {
      const auto [from, to] = layout_.bones[b];
      const std::size_t from_slot = view.slot(i, from, m), to_slot = view.slot(i, to, m);
      if (!view.truth(i, from).allFinite() || !view.truth(i, to).allFinite()) continue;
      if (!is_usable(view.status(from_slot)) || !is_usable(view.status(to_slot))) continue;
      lengths_[m * layout_.bones.size() + b].add((view.estimate(from_slot) - view.estimate(to_slot)).norm());
    }
  }

  const StatisticsLayout& layout_;
  const Axes& axes_;
  const TakeAlignments& alignments_;
  TakeStatistics result_;
  std::uint64_t block_instants_, block_ = 0;
  std::vector<LengthSpread> lengths_;                              // by method and bone
  std::vector<BySpeed> by_speed_;                                  // joint * methods + method
  std::vector<Eigen::Vector3d> estimate_m_, aligned_m_, truth_m_;  // of one body
};

// The distances of a take by cell; writes the error column of the first alignment where it is wanted.
std::vector<std::vector<double>> gather_distances(const SamplesFile& samples, const Axes& axes,
                                                  const TakeAlignments& alignments, SamplesFile* errors_to) {
  std::vector<std::vector<double>> distances_m(axes.cells());
  std::vector<float> errors;
  const auto visit = [&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot,
                         const SampleView& view) {
    errors.resize(view.block.status.size() * 3, std::numeric_limits<float>::quiet_NaN());
    for (std::size_t a = 0; a < axes.alignments; ++a) {
      const AlignedError e = error_of(view, i, j, m, slot, alignments[a].own);
      if (!e.asked || !is_usable(e.status)) continue;
      const double distance_m = e.error_m.norm();
      for (std::size_t set = 0; set < view.sets(i, j); ++set)
        distances_m[axes.cell(set, axes.group_of_joint[j], m, a)].push_back(distance_m);
      for (int axis = 0; a == 0 && axis < 3; ++axis)
        errors[slot * 3 + static_cast<std::size_t>(axis)] = static_cast<float>(e.error_m[axis]);
    }
  };
  stream_take(samples, axes, SampleColumns::positions, visit, [&](const SampleBlock& block) {
    errors.resize(block.status.size() * 3, std::numeric_limits<float>::quiet_NaN());
    if (errors_to) errors_to->write_errors(0, block.first_instant, errors);
    errors.clear();
  });
  for (std::vector<double>& of_cell_m : distances_m) of_cell_m.shrink_to_fit();
  return distances_m;
}

}  // namespace

void CellSums::merge(const CellSums& later) {
  errors.merge(later.errors);
  iterations.merge(later.iterations);
}

SamplesHeader samples_header(const Plan& plan, const PlannedTake& take) {
  SamplesHeader header;
  for (Joint joint : plan.joints) header.joints.emplace_back(name_of(joint));
  for (const Method& method : plan.methods) header.methods.push_back(method.spec.name);
  for (int s = 0; s < kSolveStatusCount; ++s)
    header.status_names.emplace_back(name_of(static_cast<SolveStatus>(s)));
  header.alignment = name_of(plan.study.alignments.front());
  header.training_share = plan.study.training_share;
  header.takes = {{take.take.id, take.instants, take.take.activity}};
  return header;
}

TakeSummary summarise_take(const SamplesFile& samples, const StatisticsLayout& layout, SamplesFile* errors) {
  const TakeAlignments alignments = align_take(samples, layout);
  const std::uint64_t instants = samples.header().takes[0].instants;
  TakeGatherer gatherer(layout, alignments, instants);
  SampleBlock block;
  for (std::uint64_t first = 0; first < instants; first += kWindow) {
    const std::uint64_t end = std::min(first + kWindow, instants);
    const std::uint64_t from = first - std::min(first, kMargin), to = std::min(end + kMargin, instants);
    samples.read(0, from, to - from, SampleColumns::all, block);
    gatherer.add(SampleView{block, layout.axes}, first - from, end - from);
  }
  return {gatherer.finish(), gather_distances(samples, layout.axes, alignments, errors),
          pair_methods(samples, layout)};
}

}  // namespace trilat
