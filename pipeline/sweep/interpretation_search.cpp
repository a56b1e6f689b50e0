// SPDX-License-Identifier: MIT
#include "pipeline/sweep/interpretation_search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>

#include "datasets/base/error.h"

namespace trilat {
namespace {

// log(ours / printed) of one cell; `censored` when the paper prints only what it stays below.
struct LogRatio {
  double value = 0.0;
  bool censored = false;
};
using LogRatios = std::vector<LogRatio>;

template <class OfCell>
LogRatios log_ratios(const SweepSummary& s, std::size_t interpretation, const OfCell& of_cell) {
  LogRatios ratios;
  for (std::size_t t = 0; t < s.thresholds.size(); ++t)
    for (std::size_t r = 0; r < s.ranges.size(); ++r)
      ratios.push_back(of_cell(s.cell(interpretation, t, r), t, r));
  return ratios;
}

double miss(const LogRatio& ratio, double log_scale) {
  const double value = ratio.value + log_scale;
  return ratio.censored ? std::max(value, 0.0) : value;
}

// The scale that makes the sum of squares least: a convex function whose slope is linear between the points
// where a censored cell comes in.
double best_log_scale(const LogRatios& ratios) {
  double log_scale = 0.0;
  for (std::size_t round = 0; round <= ratios.size(); ++round) {
    double sum = 0.0;
    double counted = 0.0;
    for (const LogRatio& ratio : ratios) {
      if (ratio.censored && ratio.value + log_scale <= 0.0) continue;
      sum += ratio.value;
      counted += 1.0;
    }
    if (counted > 0.0) log_scale = -sum / counted;
  }
  return log_scale;
}

SweepFit fit_of(std::size_t interpretation, const std::string& reported, const LogRatios& ratios,
                double log_scale) {
  double squares = 0.0, worst = 0.0;
  for (const LogRatio& ratio : ratios) {
    const double m = miss(ratio, log_scale);
    squares += m * m;
    worst = std::max(worst, std::abs(m));
  }
  return {interpretation, reported, std::sqrt(squares / static_cast<double>(ratios.size())), std::exp(worst),
          SweepCell::kNone};
}

// The least share of trials that any cell of the reading answered.
double coverage_of(const SweepSummary& s, std::size_t interpretation) {
  double least = 1.0;
  for (std::size_t t = 0; t < s.thresholds.size(); ++t)
    for (std::size_t r = 0; r < s.ranges.size(); ++r) {
      const SweepCell& cell = s.cell(interpretation, t, r);
      if (cell.asked == 0) return 0.0;
      least = std::min(least, static_cast<double>(cell.answered) / static_cast<double>(cell.asked));
    }
  return least;
}

bool is_ranked(const SweepSummary& s, std::size_t interpretation) {
  for (std::size_t t = 0; t < s.thresholds.size(); ++t)
    for (std::size_t r = 0; r < s.ranges.size(); ++r) {
      const SweepCell& cell = s.cell(interpretation, t, r);
      if (!(cell.mae_m > 0.0) || !(cell.axis_mean_mae_m() > 0.0) || !(cell.mean_iterations > 0.0))
        return false;
    }
  return coverage_of(s, interpretation) >= kMinSearchCoverage;
}

// `error_m`: which of a cell's errors the paper may have reported.
SweepFit error_fit(const SweepSummary& s, const PrintedTable1& printed, std::size_t interpretation,
                   const char* reported, const std::function<double(const SweepCell&)>& error_m) {
  const auto ratio = [&](const SweepCell& cell, std::size_t t, std::size_t r) {
    return LogRatio{std::log(error_m(cell) * 100.0 / printed.rows[t].error_cm[r]), false};
  };
  return fit_of(interpretation, reported, log_ratios(s, interpretation, ratio), 0.0);
}

SweepFit time_fit(const SweepSummary& s, const PrintedTable1& printed, std::size_t interpretation) {
  const auto ratio = [&](const SweepCell& cell, std::size_t t, std::size_t r) {
    const PrintedTable1::Row& row = printed.rows[t];
    return LogRatio{std::log(cell.mean_iterations / row.time_us[r]), row.time_is_below};
  };
  const LogRatios ratios = log_ratios(s, interpretation, ratio);
  const double log_scale = best_log_scale(ratios);
  SweepFit fit = fit_of(interpretation, "iterations", ratios, log_scale);
  fit.us_per_iteration = std::exp(log_scale);
  return fit;
}

SweepRanking ranking_of(std::vector<SweepFit> fits) {
  std::ranges::sort(fits, [](const SweepFit& a, const SweepFit& b) {
    return std::tie(a.rms_log_ratio, a.interpretation, a.reported) <
           std::tie(b.rms_log_ratio, b.interpretation, b.reported);
  });
  SweepRanking ranking;
  ranking.ranked = fits.size();
  if (fits.empty()) return ranking;
  ranking.best_rms = fits.front().rms_log_ratio;
  ranking.median_rms = fits[fits.size() / 2].rms_log_ratio;
  ranking.worst_rms = fits.back().rms_log_ratio;
  fits.resize(std::min(fits.size(), kBestListed));
  ranking.best = std::move(fits);
  return ranking;
}

// The printed gradient cannot be damped, so its partner may be.
bool same_but_gradient(const SweepInterpretation& a, const SweepInterpretation& b) {
  const auto others = [](const SweepInterpretation& i) {
    return std::tie(i.rig, i.joint, i.error_model, i.threshold_unit, i.curvature, i.stop, i.start);
  };
  return others(a) == others(b) && a.gradient != b.gradient;
}

// From the largest threshold to the smallest.
template <class OfCell>
std::vector<double> factors(const SweepSummary& s, std::size_t interpretation, const OfCell& of_cell) {
  const auto largest =
      static_cast<std::size_t>(std::ranges::max_element(s.thresholds) - s.thresholds.begin());
  const auto smallest =
      static_cast<std::size_t>(std::ranges::min_element(s.thresholds) - s.thresholds.begin());
  std::vector<double> result;
  for (std::size_t r = 0; r < s.ranges.size(); ++r)
    result.push_back(of_cell(s.cell(interpretation, smallest, r)) /
                     of_cell(s.cell(interpretation, largest, r)));
  return result;
}

void add_compromise(const SweepSummary& s, const char* best_for, const SweepRanking& ranking,
                    SweepSearch& search) {
  if (ranking.best.empty()) return;
  const std::size_t best = ranking.best.front().interpretation;
  for (std::size_t other = 0; other < s.interpretations.size(); ++other) {
    if (!same_but_gradient(s.interpretations[best], s.interpretations[other])) continue;
    const bool best_is_printed = s.interpretations[best].gradient == "printed";
    SweepCompromise c;
    c.best_for = best_for;
    c.printed = best_is_printed ? best : other;
    c.corrected = best_is_printed ? other : best;
    const auto iterations = [](const SweepCell& cell) { return cell.mean_iterations; };
    const auto error_m = [](const SweepCell& cell) { return cell.mae_m; };
    c.printed_iterations_factor = factors(s, c.printed, iterations);
    c.corrected_iterations_factor = factors(s, c.corrected, iterations);
    c.printed_error_factor = factors(s, c.printed, error_m);
    c.corrected_error_factor = factors(s, c.corrected, error_m);
    c.printed_coverage = coverage_of(s, c.printed);
    c.corrected_coverage = coverage_of(s, c.corrected);
    search.compromises.push_back(std::move(c));
  }
}

}  // namespace

SweepSearch search_interpretations(const SweepSummary& summary, const PrintedTable1& printed) {
  TRILAT_CHECK(
      summary.thresholds.size() == printed.rows.size() && summary.ranges.size() == printed.ranges_cm.size(),
      "a search has the cells of the printed table");
  SweepSearch search;
  search.tried = summary.interpretations.size();
  std::vector<SweepFit> errors, times;
  for (std::size_t i = 0; i < summary.interpretations.size(); ++i) {
    if (!is_ranked(summary, i)) continue;
    errors.push_back(error_fit(summary, printed, i, "distance", &SweepCell::mae_m));
    errors.push_back(error_fit(summary, printed, i, "axis_mean", &SweepCell::axis_mean_mae_m));
    times.push_back(time_fit(summary, printed, i));
  }
  search.errors = ranking_of(std::move(errors));
  search.times = ranking_of(std::move(times));
  add_compromise(summary, "errors", search.errors, search);
  add_compromise(summary, "times", search.times, search);
  return search;
}

}  // namespace trilat
