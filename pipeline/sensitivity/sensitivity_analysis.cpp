// SPDX-License-Identifier: MIT
#include "pipeline/sensitivity/sensitivity_analysis.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Core>

#include "datasets/base/error.h"
#include "evaluators/metrics/sobol_indices.h"
#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

constexpr std::size_t kResamples = 400;
constexpr std::size_t kBins = 6;

Estimate estimate_of(const WithInterval& w) { return {w.value, w.low, w.high}; }

// A share of all or of nothing varies in no resample: the exact bound (Clopper and Pearson 1934), a row of
// the design as one trial, since its points go together.
Estimate share_estimate(const WithInterval& share, std::size_t rows) {
  Estimate e = estimate_of(share);
  const double tail = std::pow(0.025, 1.0 / static_cast<double>(rows));
  if (e.value <= 0.0) e.high = 1.0 - tail;
  if (e.value >= 1.0) e.low = tail;
  return e;
}

double percent_of(double log_ratio) { return 100.0 * std::expm1(log_ratio); }
Estimate in_percent(const WithInterval& w) {
  return {percent_of(w.value), percent_of(w.low), percent_of(w.high)};
}

// The points of the space, row by row.
struct Space {
  std::size_t rows = 0, columns = 0;
  std::vector<const SensitivityPoint*> points;
};

Space space_of(const SensitivitySummary& s) {
  Space space{s.rows, s.factors.size() + 2, {}};
  for (const SensitivityPoint& point : s.points)
    if (point.design == "space") space.points.push_back(&point);
  TRILAT_CHECK(space.points.size() == space.rows * space.columns, "the design is whole");
  return space;
}

// Sums of what is finite, as mean and as share below 0.
struct Sums {
  double sum = 0.0, below = 0.0, n = 0.0;
  void add(double value) {
    if (!std::isfinite(value)) return;
    sum += value;
    below += value < 0.0 ? 1.0 : 0.0;
    n += 1.0;
  }
  double mean() const { return n > 0.0 ? sum / n : kNoNumber; }
  double share() const { return n > 0.0 ? below / n : kNoNumber; }
};

std::size_t bins_of(const SensitivityFactor& factor) {
  if (!factor.values.empty()) return factor.values.size();
  if (factor.whole) return static_cast<std::size_t>(std::min(factor.high - factor.low + 1.0, 12.0));
  return kBins;
}

std::size_t bin_at(double position, std::size_t bins) {
  return std::min(bins - 1, static_cast<std::size_t>(position * static_cast<double>(bins)));
}

// Of one factor: mean and share of each bin, and last where the mean changes its sign.
std::vector<double> statistics_of(const Space& space, const std::vector<double>& difference,
                                  std::size_t factor, std::size_t bins, bool is_range,
                                  std::span<const std::size_t> rows) {
  std::vector<Sums> sums(bins);
  std::vector<double> x, y;
  for (const std::size_t row : rows)
    for (std::size_t k = row * space.columns; k < (row + 1) * space.columns; ++k) {
      const double position = space.points[k]->position[factor];
      sums[bin_at(position, bins)].add(difference[k]);
      x.push_back(position);
      y.push_back(difference[k]);
    }
  std::vector<double> list;
  for (const Sums& sum : sums) list.insert(list.end(), {sum.mean(), sum.share()});
  list.push_back(is_range ? crossing_of_line(x, y) : kNoNumber);
  return list;
}

// Nothing where the crossing is beyond the range, or could be anywhere.
Estimate in_unit(const SensitivitySummary& s, std::size_t factor, const WithInterval& position) {
  if (!(position.value > 0.0 && position.value < 1.0) || !std::isfinite(position.low)) return {};
  if (position.low <= 0.0 && position.high >= 1.0) return {};
  return {s.value_at(factor, position.value), s.value_at(factor, position.low),
          s.value_at(factor, position.high)};
}

ClaimByFactor by_factor(const SensitivitySummary& s, const Space& space,
                        const std::vector<double>& difference, std::size_t factor,
                        const SobolIndices& indices) {
  const SensitivityFactor& f = s.factors[factor];
  const std::size_t bins = bins_of(f);
  const std::vector<WithInterval> list =
      bootstrap_rows(space.rows, kResamples, s.seed, [&](std::span<const std::size_t> rows) {
        return statistics_of(space, difference, factor, bins, f.values.empty() && !f.whole, rows);
      });
  ClaimByFactor result{.factor = f.name,
                       .first = estimate_of(indices.first),
                       .total = estimate_of(indices.total),
                       .break_even = in_unit(s, factor, list.back()),
                       .bins = {}};
  for (std::size_t b = 0; b < bins; ++b)
    result.bins.push_back({(static_cast<double>(b) + 0.5) / static_cast<double>(bins),
                           in_percent(list[2 * b]), estimate_of(list[2 * b + 1])});
  return result;
}

// The mean over the campaigns of the simulation as it is, with its interval by Student's t.
Estimate as_it_is(const SensitivitySummary& s, const SensitivityClaim& claim, std::size_t alignment) {
  std::vector<double> values;
  for (const SensitivityPoint& point : s.points)
    if (const double percent = difference_percent(claim, s.methods, point, alignment);
        point.design == "default" && std::isfinite(percent))
      values.push_back(std::log1p(0.01 * percent));
  if (values.empty()) return {};
  const Eigen::Map<const Eigen::ArrayXd> x(values.data(), static_cast<Eigen::Index>(values.size()));
  const double mean = x.mean();
  if (values.size() < 2) return {percent_of(mean), kNoNumber, kNoNumber};
  const auto n = static_cast<double>(values.size());
  const double half =
      student_quantile(values.size() - 1) * std::sqrt((x - mean).square().sum() / (n - 1.0) / n);
  return in_percent({mean, mean - half, mean + half});
}

// By point, the logarithm of the ratio; NaN also outside the part.
std::vector<double> differences_of(const SensitivitySummary& s, const Space& space,
                                   const SensitivityClaim& claim, std::size_t alignment,
                                   const SpacePart& part) {
  const auto factor = static_cast<std::size_t>(
      std::ranges::find(s.factors, part.factor, &SensitivityFactor::name) - s.factors.begin());
  std::vector<double> differences;
  for (const SensitivityPoint* point : space.points) {
    const double value = factor < s.factors.size() ? s.value_at(factor, point->position[factor]) : 0.0;
    const bool is_outside = factor < s.factors.size() && !(part.low <= value && value <= part.high);
    differences.push_back(
        is_outside ? kNoNumber : std::log1p(0.01 * difference_percent(claim, s.methods, *point, alignment)));
  }
  return differences;
}

ClaimIn claim_in(const SensitivitySummary& s, const Space& space, const SensitivityClaim& claim,
                 std::size_t alignment, const SpacePart& part) {
  ClaimIn result{.alignment = s.alignments[alignment], .part = part.name};
  const std::vector<double> difference = differences_of(s, space, claim, alignment, part);
  std::set<std::size_t> rows_with_any;
  for (std::size_t k = 0; k < difference.size(); ++k) {
    if (std::isnan(difference[k])) continue;
    result.worst_percent = std::fmax(result.worst_percent, percent_of(difference[k]));
    ++result.compared;
    rows_with_any.insert(k / space.columns);
  }
  const std::vector<WithInterval> all =
      bootstrap_rows(space.rows, kResamples, s.seed, [&](std::span<const std::size_t> rows) {
        Sums sums;
        for (const std::size_t row : rows)
          for (std::size_t k = row * space.columns; k < (row + 1) * space.columns; ++k)
            sums.add(difference[k]);
        return std::vector<double>{sums.share(), sums.mean()};
      });
  result.share = share_estimate(all[0], rows_with_any.size());
  result.difference_percent = in_percent(all[1]);
  result.default_percent = as_it_is(s, claim, alignment);
  return result;
}

void analyse_claim(const SensitivitySummary& s, const Space& space, SensitivityClaim& claim) {
  std::vector<SpacePart> parts{{}};
  parts.insert(parts.end(), s.parts.begin(), s.parts.end());
  for (const SpacePart& part : parts)
    for (std::size_t a = 0; a < s.alignments.size(); ++a)
      claim.side_by_side.push_back(claim_in(s, space, claim, a, part));
  const ClaimIn& first = claim.side_by_side.front();
  claim.silent = space.points.size() - first.compared;
  claim.share = first.share;
  claim.difference_percent = first.difference_percent;
  claim.worst_percent = first.worst_percent;
  claim.default_percent = first.default_percent;
  const std::vector<double> difference = differences_of(s, space, claim, 0, {});
  const std::vector<SobolIndices> indices = sobol_indices(difference, s.factors.size(), kResamples, s.seed);
  for (std::size_t f = 0; f < s.factors.size(); ++f)
    claim.factors.push_back(by_factor(s, space, difference, f, indices[f]));
}

std::vector<Estimate> best_shares(const SensitivitySummary& s, const Space& space) {
  // Which method errs less than every other on the samples that both answer; their number when none does.
  const auto best = [methods = s.methods.size()](const SensitivityPoint& point) {
    const auto beats = [&](std::size_t m, std::size_t other) {
      return m == other || !(point.paired_m[m * methods + other] > point.paired_m[other * methods + m]);
    };
    std::size_t m = 0;
    for (; m < methods; ++m) {
      if (!std::isfinite(point.paired_m[m * methods + m])) continue;
      std::size_t others = 0;
      while (others < methods && beats(m, others)) ++others;
      if (others == methods) break;
    }
    return m;
  };
  std::vector<Estimate> shares;
  for (const WithInterval& share :
       bootstrap_rows(space.rows, kResamples, s.seed, [&](std::span<const std::size_t> rows) {
         std::vector<double> count(s.methods.size() + 1, 0.0);
         for (const std::size_t row : rows)
           for (std::size_t k = row * space.columns; k < (row + 1) * space.columns; ++k)
             count[best(*space.points[k])] += 1.0 / static_cast<double>(rows.size() * space.columns);
         count.pop_back();
         return count;
       }))
    shares.push_back(share_estimate(share, space.rows));
  return shares;
}

}  // namespace

void analyse(SensitivitySummary& summary) {
  const Space space = space_of(summary);
  for (SensitivityClaim& claim : summary.claims) analyse_claim(summary, space, claim);
  summary.best_share = best_shares(summary, space);
}

}  // namespace trilat
