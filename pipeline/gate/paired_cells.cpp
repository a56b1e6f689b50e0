// SPDX-License-Identifier: MIT
#include "pipeline/gate/paired_cells.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "datasets/results/summary.h"
#include "evaluators/metrics/student.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

using Eigen::Index;

Index as_index(std::size_t i) { return static_cast<Index>(i); }

// The takes of one condition, those of one participant together, and the cluster of each of their blocks.
struct ConditionPairs {
  std::vector<const PairedTake*> takes;
  std::vector<std::size_t> clusters;
};

std::vector<std::size_t> by_participant(const std::vector<const PairedTake*>& takes) {
  std::vector<std::size_t> clusters;
  for (std::size_t t = 0; t < takes.size(); ++t) {
    const bool same = t > 0 && takes[t]->participant == takes[t - 1]->participant;
    const std::size_t cluster = clusters.empty() ? 0 : clusters.back() + (same ? 0 : 1);
    clusters.insert(clusters.end(), static_cast<std::size_t>(takes[t]->sums.rows()), cluster);
  }
  return clusters;
}

std::size_t clusters_of(const std::vector<std::size_t>& clusters) {
  return clusters.empty() ? 0 : clusters.back() + 1;
}

// Every `length` blocks of a take are a cluster.
std::vector<std::size_t> by_time(const std::vector<const PairedTake*>& takes, std::size_t length) {
  std::vector<std::size_t> clusters;
  std::size_t next = 0;
  for (const PairedTake* take : takes) {
    const auto rows = static_cast<std::size_t>(take->sums.rows());
    const std::size_t whole = std::max<std::size_t>(1, rows / length);  // the last takes what is left over
    for (std::size_t b = 0; b < rows; ++b) clusters.push_back(next + std::min(b / length, whole - 1));
    if (rows > 0) next += whole;
  }
  return clusters;
}

ConditionPairs pairs_of(const PairedStudy& study, const std::string& condition,
                        const PairedOptions& options) {
  ConditionPairs pairs;
  for (const PairedTake& take : study.takes)
    if (take.condition == condition && take.sums.rows() > 0) pairs.takes.push_back(&take);
  std::ranges::stable_sort(
      pairs.takes, [](const PairedTake* a, const PairedTake* b) { return a->participant < b->participant; });
  pairs.clusters = by_participant(pairs.takes);
  if (clusters_of(pairs.clusters) < kFewestJudged && options.same_inputs) {
    constexpr auto kBlocks = static_cast<std::size_t>(static_cast<double>(kLongBlock_s) / kPairedBlock_s);
    pairs.clusters = by_time(pairs.takes, kBlocks);
    if (clusters_of(pairs.clusters) < kFewestLongBlocks) pairs.clusters = by_time(pairs.takes, 1);
  }
  return pairs;
}

// Whether anything of a cell is not as it was.
bool differs(const ConditionPairs& pairs, std::size_t cell) {
  for (const PairedTake* take : pairs.takes) {
    const PairedCounts& counts = take->cells[cell];
    if (counts.lost + counts.gained > 0 || counts.status_before != counts.status_now) return true;
    const Index column = as_index(cell * PairedColumns::count + PairedColumns::difference);
    if ((take->sums.col(column).array() != 0.0).any()) return true;
  }
  return false;
}

// By cluster.
RowMatrix gathered(const ConditionPairs& pairs, const std::vector<std::size_t>& cells) {
  constexpr auto kColumns = static_cast<Index>(PairedColumns::count);
  RowMatrix sums = RowMatrix::Zero(as_index(clusters_of(pairs.clusters)), as_index(cells.size()) * kColumns);
  std::size_t next = 0;
  for (const PairedTake* take : pairs.takes)
    for (Index b = 0; b < take->sums.rows(); ++b, ++next)
      for (std::size_t c = 0; c < cells.size(); ++c)
        sums.block(as_index(pairs.clusters[next]), as_index(c) * kColumns, 1, kColumns) +=
            take->sums.block(b, as_index(cells[c]) * kColumns, 1, kColumns);
  return sums;
}

// Of every cell and, when there are two or more, of their mean: the share that the error grew by, the mean
// before, and the shares of samples lost and clamped.
struct Wanted {
  static constexpr std::size_t quantities_a_cell = 4;
  std::vector<RatioColumns> ratios;
  std::vector<RatioQuantity> quantities;
};

Wanted wanted_of(std::size_t cells) {
  Wanted wanted;
  const auto add = [&](std::size_t numerator, std::size_t denominator) {
    for (std::size_t c = 0; c < cells; ++c)
      wanted.ratios.push_back({c * PairedColumns::count + numerator, c * PairedColumns::count + denominator});
  };
  add(PairedColumns::difference, PairedColumns::both);
  add(PairedColumns::before, PairedColumns::both);
  add(PairedColumns::net_lost, PairedColumns::asked);
  add(PairedColumns::net_clamped, PairedColumns::both);
  const auto add_quantities = [&](std::size_t first, std::size_t count) {
    wanted.quantities.push_back({{first, count}, RatioRange{cells + first, count}});
    wanted.quantities.push_back({{cells + first, count}});
    wanted.quantities.push_back({{2 * cells + first, count}});
    wanted.quantities.push_back({{3 * cells + first, count}});
  };
  for (std::size_t c = 0; c < cells; ++c) add_quantities(c, 1);
  if (cells >= 2) add_quantities(0, cells);
  return wanted;
}

double chance_of(const IntervalEstimate& e) {
  if (!std::isfinite(e.value) || e.value == 0.0) return 1.0;
  if (e.clusters < 2 || std::isnan(e.standard_error)) return kNoNumber;
  return student_two_sided(e.value / e.standard_error, e.clusters - 1);
}

Change change_of(const IntervalEstimate& e) {
  return {100.0 * e.value, 100.0 * e.low, 100.0 * e.high, chance_of(e)};
}

void set_numbers(ComparedCell& cell, const IntervalEstimate* found) {
  const IntervalEstimate &share = found[0], &before = found[1], &lost = found[2], &clamped = found[3];
  cell.before_m = before.value;
  cell.now_m = before.value * (1.0 + share.value);
  cell.clusters = share.clusters;
  cell.error = change_of(share);
  cell.lost = change_of(lost);
  cell.clamped = change_of(clamped);
}

void set_statuses(ComparedCell& result, const PairedCounts& all) {
  std::uint64_t fewer = 0;
  for (std::size_t s = 0; s < all.status_now.size(); ++s) {
    const std::uint64_t before = all.status_before[s], now = all.status_now[s];
    if (before == now) continue;
    if (before > now) fewer += before - now;
    result.status_changes += fmt::format("{}{} {} -> {}", result.status_changes.empty() ? "" : ", ",
                                         name_of(static_cast<SolveStatus>(s)), before, now);
  }
  if (all.asked > 0)
    result.moved_percent = 100.0 * static_cast<double>(fewer) / static_cast<double>(all.asked);
}

void set_counts(ComparedCell& result, const ConditionPairs& pairs, const std::vector<std::size_t>& cells) {
  PairedCounts all;
  double worst_share = 0.0;
  for (const PairedTake* take : pairs.takes) {
    PairedCounts here;
    for (const std::size_t cell : cells) here.merge(take->cells[cell]);
    all.merge(here);
    const auto before = static_cast<double>(here.answered_before());
    const double share = before > 0.0 ? (before - static_cast<double>(here.answered_now())) / before : 0.0;
    if (share <= worst_share) continue;
    worst_share = share;
    result.worst_take = take->id;
    result.worst_take_answered_before = here.answered_before();
    result.worst_take_answered_now = here.answered_now();
  }
  result.asked = all.asked;
  result.both = all.both;
  result.lost_samples = all.lost;
  result.gained_samples = all.gained;
  result.answered_before = all.answered_before();
  result.answered_now = all.answered_now();
  set_statuses(result, all);
}

// The cells of one method under one alignment and set.
std::vector<ComparedCell> method_cells(const PairedStudy& study, const ConditionPairs& pairs,
                                       std::size_t alignment, std::size_t set, std::size_t method) {
  std::vector<std::size_t> cells, groups;
  bool any = false;
  for (std::size_t g = 0; g < study.axes.groups; ++g) {
    const std::size_t cell = study.axes.cell(alignment, set, g, method);
    const auto asked = [&](const PairedTake* take) { return take->cells[cell].asked > 0; };
    if (std::ranges::none_of(pairs.takes, asked)) continue;
    any |= differs(pairs, cell);
    cells.push_back(cell);
    groups.push_back(g);
  }
  if (!any) return {};
  const Wanted wanted = wanted_of(cells.size());
  const auto found = student_intervals(gathered(pairs, cells), wanted.ratios, wanted.quantities);
  std::vector<ComparedCell> result;
  for (std::size_t k = 0; Wanted::quantities_a_cell * k < found.size(); ++k) {
    const bool is_average = k == cells.size();
    if (!is_average && !differs(pairs, cells[k])) continue;
    ComparedCell cell;
    cell.study = study.study;
    cell.method = study.methods[method];
    cell.group = is_average ? kAverageGroup : study.groups[groups[k]];
    cell.alignment = study.alignments[alignment];
    cell.condition = pairs.takes.front()->condition;
    if (set > 0) cell.condition = occluded_condition(cell.condition);
    set_numbers(cell, &found[Wanted::quantities_a_cell * k]);
    set_counts(cell, pairs, is_average ? cells : std::vector{cells[k]});
    result.push_back(std::move(cell));
  }
  return result;
}

}  // namespace

std::vector<ComparedCell> compared_cells(const PairedStudy& study, const PairedOptions& options) {
  std::vector<std::string> conditions;
  for (const PairedTake& take : study.takes)
    if (std::ranges::find(conditions, take.condition) == conditions.end())
      conditions.push_back(take.condition);
  std::vector<ComparedCell> all;
  const PairedAxes& axes = study.axes;
  for (const std::string& condition : conditions) {
    const ConditionPairs pairs = pairs_of(study, condition, options);
    if (pairs.takes.empty()) continue;
    std::vector<std::vector<ComparedCell>> found(axes.alignments * axes.sets * axes.methods);
    parallel_for_index(found.size(), 1, [&](std::size_t k) {
      found[k] = method_cells(study, pairs, k / (axes.sets * axes.methods), k / axes.methods % axes.sets,
                              k % axes.methods);
    });
    for (auto& cells : found) std::move(cells.begin(), cells.end(), std::back_inserter(all));
  }
  return all;
}

void PairedCounts::merge(const PairedCounts& later) {
  asked += later.asked;
  both += later.both;
  lost += later.lost;
  gained += later.gained;
  for (std::size_t s = 0; s < status_now.size(); ++s) {
    status_before[s] += later.status_before[s];
    status_now[s] += later.status_now[s];
  }
}

PairedTakeSums::PairedTakeSums(const PairedAxes& axes, std::uint64_t blocks)
    : axes_(axes),
      sums_(RowMatrix::Zero(static_cast<Eigen::Index>(blocks),
                            static_cast<Eigen::Index>(axes.cells() * PairedColumns::count))),
      counts_(axes.cells()) {}

void PairedTakeSums::add(std::uint64_t block, std::size_t joint, std::size_t method, std::size_t sets,
                         const PairedAnswer& before, const PairedAnswer& now) {
  for (std::size_t a = 0; a < axes_.alignments; ++a)
    for (std::size_t set = 0; set < sets; ++set) {
      const std::size_t cell = axes_.cell(a, set, axes_.group_of_joint[joint], method);
      double* sums =
          &sums_(static_cast<Eigen::Index>(block), static_cast<Eigen::Index>(cell * PairedColumns::count));
      PairedCounts& counts = counts_[cell];
      const bool was = !std::isnan(before.error_m[a]), is = !std::isnan(now.error_m[a]);
      ++counts.asked;
      counts.both += was && is;
      counts.lost += was && !is;
      counts.gained += is && !was;
      ++counts.status_before[static_cast<std::size_t>(before.status)];
      ++counts.status_now[static_cast<std::size_t>(now.status)];
      sums[PairedColumns::asked] += 1.0;
      sums[PairedColumns::net_lost] += static_cast<double>(was) - static_cast<double>(is);
      if (!was || !is) continue;
      sums[PairedColumns::difference] += now.error_m[a] - before.error_m[a];
      sums[PairedColumns::both] += 1.0;
      sums[PairedColumns::before] += before.error_m[a];
      sums[PairedColumns::net_clamped] += static_cast<double>(now.status == SolveStatus::clamped) -
                                          static_cast<double>(before.status == SolveStatus::clamped);
    }
}

void PairedTakeSums::finish(PairedTake& take) {
  take.sums = std::move(sums_);
  take.cells = std::move(counts_);
}

}  // namespace trilat
