// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// Probabilities of chance, corrected for how many are looked at (Holm 1979): rejecting what comes out at or
// below alpha makes one false rejection or more with probability alpha at most, however they depend on each
// other. NaN is no test: it stays NaN and counts for none.
std::vector<double> holm_adjusted(std::span<const double> p);

// The quantile of Student's t for two-sided intervals of level 1 - alpha; NaN for 0 degrees of
// freedom.
double student_quantile(std::size_t degrees, double alpha = 0.05);

// The probability that Student's t of so many degrees of freedom is at least as far from 0 as `t`, on either
// side. 1 for t = 0, 0 for infinite t, NaN for NaN or no degrees.
double student_two_sided(double t, std::size_t degrees);

// The squared length, in variances of one axis, that a normal vector of so many dimensions exceeds as rarely
// as a normal number exceeds `sigmas` standard deviations on either side: the quantile of chi-square. Beyond
// 37 standard deviations the probability underflows, and the limit is the square of `sigmas`.
double chi_square_limit(double sigmas, double dimensions);

// The quantile of the gamma distribution at probability `p`. Shape and scale must be
// finite and greater than 0, `p` between 0 and 1: InternalError otherwise. GSL's own inverse fails for a
// fifth of the shapes beyond 2000, so the distribution itself is inverted.
double gamma_quantile(double p, double shape, double scale);

// A ratio of sums, of which every cluster (a participant, a sensor unit, a run) has its own part, times a
// weight.
struct WeightedRatio {
  std::vector<double> numerator, denominator;  // by cluster; a denominator is 0 where it has no samples
  double weight = 1.0;
};

// The sum of some ratios, divided by the sum of others when there are any.
struct Contrast {
  std::vector<WeightedRatio> value, base;
};

struct Estimate {
  double value = kNaN;
  double standard_error = kNaN;  // between clusters, by linearisation; NaN for fewer than 2
  std::size_t clusters = 0;      // with samples in any ratio of `value`
  // 95 %, or 1 - alpha, by Student's t with one degree of freedom less than clusters; NaN without a standard
  // error.
  double low() const;
  double high() const;
  double low(double alpha) const;
  double high(double alpha) const;
  double p_value() const;  // of a difference from zero, two-sided
  // low() of a mean of lengths or other sizes, none of which is below zero.
  double low_of_size() const { return low() < 0.0 ? 0.0 : low(); }
};

// Every cluster enters all its ratios at once, so that what its samples share cancels where it is subtracted.
// NaN when a ratio has no samples at all. The standard error is that between clusters, by linearisation: u_k
// is what cluster k pulls the value by, se^2 = n / (n - 1) sum u_k^2 (Cochran, Sampling Techniques, 1977,
// section 6.4). How often the intervals cover the truth: docs/explanation/intervals.md.
Estimate solve_contrast(const Contrast& contrast);

// Whether a method errs significantly more than the best of `others` methods, by the paired difference to it:
// a one-sided test at 0.05 / others (Bonferroni), since the best was chosen by the data that it is tested
// on. The methods that do not then hold the truly best in 95 % of campaigns at least. False without a
// standard error.
bool differs_significantly(const Estimate& difference, std::size_t others);

// The 95 % interval of the mean size sum(sums) / sum(counts), one of each a cluster; not below zero, and NaN
// with fewer than two.
std::pair<double, double> mean_interval(const std::vector<double>& sums, const std::vector<double>& counts);

// A share, with its exact 95 % interval by Clopper and Pearson 1934: never below 0 nor above 1, and never of
// no width.
struct ShareEstimate {
  double value = kNaN, low = kNaN, high = kNaN;
  double successes = kNaN, trials = kNaN;  // what the interval is made from; of clusters not whole
  std::size_t clusters = 0;                // with samples

  // The probability of so many successes or more (or fewer) if the true share were `share`; 1 where nothing
  // is known.
  double chance_of_more(double share) const;
  double chance_of_fewer(double share) const;
};

// The share of successes in independent trials, each of which is a cluster.
ShareEstimate estimate_share(double successes, double trials);

// The share in samples that are correlated within clusters, by cluster: that of as many independent trials as
// give the standard error between clusters (Korn and Graubard, Survey Methodology 24, 1998). Where all
// clusters have the same share, nothing is known of that error, and each counts as one trial. NaN bounds for
// fewer than two clusters.
ShareEstimate estimate_share(const std::vector<double>& successes, const std::vector<double>& samples);

// The quantiles of `values`, in the order asked for, which rises from 0 to 1. Quantile q of n values in order
// is x at position (n - 1) q, linear between neighbours (type 7 of Hyndman and Fan 1996); NaN without values.
// Infinity is allowed; InternalError for NaN.
std::vector<double> quantiles_of(std::vector<double> values, const std::vector<double>& quantiles);

// Differences of one person: how many, their sum and the sum of their squares.
struct DifferenceSums {
  double n = 0.0, sum = 0.0, sum2 = 0.0;
};

// How far one measurement is from another, in their unit: the mean difference, and the limits within which 95
// % of single differences lie, each with its 95 % interval. NaN where it cannot be known.
struct Agreement {
  double bias = kNaN, bias_low = kNaN, bias_high = kNaN;
  double sd = kNaN;  // of a single difference, of any person
  double lower = kNaN, lower_low = kNaN, lower_high = kNaN;
  double upper = kNaN, upper_low = kNaN, upper_high = kNaN;
  std::size_t persons = 0;
};

// Bland and Altman, "Measuring agreement in method comparison studies", 1999, section 5.3: several
// measurements of each person, whose true value varies. The variance of a single difference is that within
// persons and that between them, by one-way analysis of variance; limits are bias -+ 1.96 sd. Intervals are
// Student's t with persons - 1 degrees of freedom, the standard error of a limit being that of the bias and,
// beside it, 1.96 times that of sd by Satterthwaite's degrees of freedom. Of a single person there are the
// bias and, from within, the limits, without intervals. NaN without differences.
Agreement limits_of_agreement(std::span<const DifferenceSums> persons);

}  // namespace trilat
