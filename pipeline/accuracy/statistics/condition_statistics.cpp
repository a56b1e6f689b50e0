// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/condition_statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "evaluators/metrics/block_bootstrap.h"
#include "evaluators/metrics/body_metrics.h"
#include "evaluators/metrics/quantile_selection.h"

namespace trilat {
namespace {

using Eigen::Index;

Index as_index(std::size_t i) { return static_cast<Index>(i); }

Index rows_of(const ConditionTakes& condition) { return as_index(condition.resamples.first_block.back()); }

// The sums of one method by alignment, group and column, gathered from all takes.
Eigen::MatrixXd cell_sums(const ConditionTakes& condition, const StatisticsLayout& layout, std::size_t set,
                          std::size_t method, const std::vector<std::size_t>& groups) {
  const Axes& axes = layout.axes;
  Eigen::MatrixXd sums(rows_of(condition), as_index(axes.alignments * groups.size() * CellColumns::count));
  Index first = 0;
  for (const TakeStatistics* take : condition.takes) {
    for (std::size_t a = 0; a < axes.alignments; ++a)
      for (std::size_t g = 0; g < groups.size(); ++g)
        sums.block(first, as_index((a * groups.size() + g) * CellColumns::count), take->cells.rows(),
                   as_index(CellColumns::count)) =
            take->cells.middleCols(as_index(axes.cell(set, groups[g], method, a) * CellColumns::count),
                                   as_index(CellColumns::count));
    first += take->cells.rows();
  }
  return sums;
}

// The mean over both directions; NaN when no neighbour has a truth.
double one_frame_m(const ConditionTakes& condition, std::size_t cell) {
  OneFrame sum;
  for (const TakeStatistics* take : condition.takes) {
    sum.later_m.merge(take->one_frame[cell].later_m);
    sum.earlier_m.merge(take->one_frame[cell].earlier_m);
  }
  return (std::abs(sum.later_m.value()) + std::abs(sum.earlier_m.value())) / 2.0;
}

// The ratios and quantities of every alignment: distances, differences and percentages of each group, then of
// their average.
struct Wanted {
  std::vector<RatioColumns> ratios;
  std::vector<BootstrapQuantity> quantities;
};

Wanted wanted_of(std::size_t alignments, std::size_t groups, bool with_differences) {
  Wanted wanted;
  for (std::size_t a = 0; a < alignments; ++a) {
    const std::size_t distances = wanted.ratios.size();
    const std::size_t differences = distances + groups, references = differences + groups;
    const auto add_ratios = [&](std::size_t numerator, std::size_t denominator) {
      for (std::size_t g = 0; g < groups; ++g) {
        const std::size_t first = (a * groups + g) * CellColumns::count;
        wanted.ratios.push_back({first + numerator, first + denominator});
      }
    };
    const auto add_quantities = [&](std::size_t group, std::size_t count) {
      wanted.quantities.push_back({{distances + group, count}});
      if (!with_differences) return;
      wanted.quantities.push_back({{differences + group, count}});
      wanted.quantities.push_back({{differences + group, count}, RatioRange{references + group, count}});
    };
    add_ratios(CellColumns::distance, CellColumns::answered);
    if (with_differences) {
      add_ratios(CellColumns::difference, CellColumns::both);
      add_ratios(CellColumns::reference, CellColumns::both);
    }
    for (std::size_t g = 0; g < groups; ++g) add_quantities(g, 1);
    if (groups >= 2) add_quantities(0, groups);
  }
  return wanted;
}

// A mean distance is not negative, whatever the width of its interval; NaN stays.
double not_below_zero(double distance_m) { return distance_m < 0.0 ? 0.0 : distance_m; }

DifferenceCell difference_of(const IntervalEstimate& difference, const IntervalEstimate& share) {
  DifferenceCell cell;
  cell.clusters = difference.clusters;
  cell.difference_m = difference.value;
  cell.low_m = difference.low;
  cell.high_m = difference.high;
  cell.percent_of_reference = 100.0 * share.value;
  cell.percent_low = 100.0 * share.low;
  cell.percent_high = 100.0 * share.high;
  cell.percent_of_method = 100.0 * share.value / (1.0 + share.value);
  if (!std::isfinite(cell.percent_of_method)) cell.percent_of_method = kNoNumber;
  return cell;
}

}  // namespace

ConditionTakes condition_takes(std::vector<const TakeStatistics*> takes, std::vector<std::size_t> participant,
                               const ResampleOptions& options) {
  std::vector<std::size_t> order(takes.size()), clusters;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return participant[a] < participant[b]; });
  ConditionTakes result;
  for (const std::size_t t : order) {
    const bool same = !result.participant.empty() && result.participant.back() == participant[t];
    const std::size_t cluster = clusters.empty() ? 0 : clusters.back() + (same ? 0 : 1);
    result.takes.push_back(takes[t]);
    result.participant.push_back(participant[t]);
    clusters.insert(clusters.end(), static_cast<std::size_t>(takes[t]->cells.rows()), cluster);
  }
  result.resamples = draw_resamples(clusters, options);
  return result;
}

MethodIntervals method_intervals(const ConditionTakes& condition, const StatisticsLayout& layout,
                                 std::size_t set, std::size_t method,
                                 const std::vector<std::size_t>& groups) {
  const bool with_differences = method != layout.reference;
  const Eigen::MatrixXd sums = cell_sums(condition, layout, set, method, groups);
  const Wanted wanted = wanted_of(layout.axes.alignments, groups.size(), with_differences);
  const auto found = solve_intervals(sums, condition.resamples, wanted.ratios, wanted.quantities);
  MethodIntervals result;
  std::size_t next = 0;
  for (std::size_t a = 0; a < layout.axes.alignments; ++a) {
    double one_frame_sum_m = 0.0;
    std::uint64_t both_sum = 0;
    for (std::size_t g = 0; g < groups.size() + (groups.size() >= 2 ? 1 : 0); ++g) {
      const bool is_average = g == groups.size();
      const IntervalEstimate& e = found[next++];
      CellInterval cell;
      cell.group = is_average ? layout.axes.groups : groups[g];
      cell.alignment = a;
      cell.low_m = not_below_zero(e.low);
      cell.high_m = e.high;
      cell.clusters = e.clusters;
      cell.one_frame_m = is_average ? one_frame_sum_m / static_cast<double>(groups.size())
                                    : one_frame_m(condition, layout.axes.cell(set, groups[g], method, a));
      one_frame_sum_m += cell.one_frame_m;
      result.cells.push_back(cell);
      if (!with_differences) continue;
      DifferenceCell difference = difference_of(found[next], found[next + 1]);
      next += 2;
      const std::size_t column = (a * groups.size() + g) * CellColumns::count + CellColumns::both;
      difference.n = is_average ? both_sum : static_cast<std::uint64_t>(sums.col(as_index(column)).sum());
      both_sum += difference.n;
      result.differences.push_back(difference);
    }
  }
  return result;
}

BodyCell body_cell(const ConditionTakes& condition, std::size_t method) {
  Eigen::MatrixXd sums(rows_of(condition), as_index(BodySumColumns::count));
  Index first = 0;
  TakeBodies bodies;
  Mean truth_jerk_m_s3;
  for (const TakeStatistics* take : condition.takes) {
    sums.middleRows(first, take->bodies.rows()) =
        take->bodies.middleCols(as_index(method * BodySumColumns::count), as_index(BodySumColumns::count));
    first += take->bodies.rows();
    const TakeBodies& here = take->of_method[method];
    for (std::size_t r = 0; r < bodies.within.size(); ++r) bodies.within[r] += here.within[r];
    bodies.joints += here.joints;
    bodies.bones = std::max(bodies.bones, here.bones);
    bodies.bone_sd_m.merge(here.bone_sd_m);
    bodies.jerk_m_s3.merge(here.jerk_m_s3);
    truth_jerk_m_s3.merge(take->truth_jerk_m_s3);
  }
  const std::vector<RatioColumns> ratios{{BodySumColumns::mpjpe, BodySumColumns::whole},
                                         {BodySumColumns::pa_mpjpe, BodySumColumns::pa_whole}};
  const std::vector<BootstrapQuantity> quantities{{{0, 1}}, {{1, 1}}};
  const auto found = solve_intervals(sums, condition.resamples, ratios, quantities);
  BodyCell cell;
  cell.instants = static_cast<std::uint64_t>(sums.col(as_index(BodySumColumns::whole)).sum());
  cell.clusters = found[0].clusters;
  cell.mpjpe_m = found[0].value;
  cell.mpjpe_low_m = not_below_zero(found[0].low);
  cell.mpjpe_high_m = found[0].high;
  cell.pa_mpjpe_m = found[1].value;
  cell.pa_mpjpe_low_m = not_below_zero(found[1].low);
  cell.pa_mpjpe_high_m = found[1].high;
  for (std::size_t r = 0; bodies.joints > 0 && r < cell.pck.size(); ++r)
    cell.pck[r] = static_cast<double>(bodies.within[r]) / static_cast<double>(bodies.joints);
  cell.bones = bodies.bones;
  cell.bone_length_sd_m = bodies.bone_sd_m.value();
  cell.jitter_m_s3 = bodies.jerk_m_s3.value();
  cell.truth_jitter_m_s3 = truth_jerk_m_s3.value();
  return cell;
}

TruthFloor truth_floor(const ConditionTakes& condition, std::size_t group, double clock_error_s) {
  Mean speed_m_s;
  std::vector<double> sigma_m;
  for (const TakeStatistics* take : condition.takes) {
    const TakeTruth& truth = take->of_group[group];
    speed_m_s.merge(truth.speed_m_s);
    sigma_m.insert(sigma_m.end(), truth.noise_sigma_m.begin(), truth.noise_sigma_m.end());
  }
  TruthFloor floor;
  // noise is the same all the time and what is left of the movement is not: the calm quarter is nearest to it
  const double sigma = quantiles_of(sigma_m, {0.25})[0];
  floor.mocap_noise_m = sigma * std::sqrt(8.0 / std::numbers::pi);  // mean of a Maxwell distribution
  floor.mean_speed_m_s = speed_m_s.value();
  floor.clock_error_s = clock_error_s;
  return floor;
}

}  // namespace trilat
