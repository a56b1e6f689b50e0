// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "datasets/results/claims.h"
#include "datasets/results/numbers.h"
#include "evaluators/metrics/statistics.h"

namespace trilat {

// On which side of a margin a number has to lie for a claim to hold: above it, below it, or nearer to zero
// than it.
struct ClaimBound {
  enum class Side { more_than, less_than, within } side = Side::more_than;
  double margin = 0.0;  // in the number's unit
};
inline constexpr ClaimBound more_than(double margin) { return {ClaimBound::Side::more_than, margin}; }
inline constexpr ClaimBound less_than(double margin) { return {ClaimBound::Side::less_than, margin}; }
inline constexpr ClaimBound within(double margin) { return {ClaimBound::Side::within, margin}; }

// A measured value, as a share of one (its unit is "%" then) or in the unit. A plain number was not sampled.
using MeasuredNumber = std::variant<Estimate, ShareEstimate, double>;

struct Measurement {
  std::string what = {};  // "linear against nonlinear, head"
  std::string unit = {};  // "%" or "cm"
  MeasuredNumber number = Estimate{};
  std::string over = "participants";
  double compared = kNaN;    // share of the samples that both methods answer
  std::string missing = {};  // why nothing was measured; the rest is empty then
};

// A stored number with the spread that its interval shows; without an interval none is known.
Estimate estimate_of(const Number& number);

// Twice the one-sided probabilities, at most 1, that a number lies so far on its side of the bound (or on the
// other) by chance: by Student's t of an estimate between clusters, exact of a share. 1 where nothing is
// known of the spread; 0 and 1 where nothing was sampled.
struct ClaimPValues {
  double holds = 1.0, fails = 1.0;
  double decided() const { return holds < fails ? holds : fails; }
};
ClaimPValues p_values_of(const MeasuredNumber& number, const ClaimBound& bound);

// A claim of several numbers holds when all do (the largest of their p values: Berger 1982) and fails when
// one does (the smallest, times their number).
ClaimPValues chance_of_all(const std::vector<ClaimPValues>& numbers);

// Number of a claim by a measurement; without a bound where nothing is to be decided.
ClaimNumber claim_number(const std::string& claim, const Measurement& measured,
                         const std::optional<ClaimBound>& bound);

}  // namespace trilat
