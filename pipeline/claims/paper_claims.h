// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "datasets/base/document.h"
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

// One number of a claim: its key in numbers.csv, to which an accuracy study adds its alignment and a
// calibration study the recording of stated distances as condition.
struct ClaimedNumber {
  NumberKey key;
  std::string what = {};                 // empty: "METHOD against AGAINST, GROUP"
  double less = 0.0;                     // is taken off the value, in SI units
  std::optional<ClaimBound> bound = {};  // instead of the claim's

  static void fields(ClaimedNumber& self, Fields& f);
};

// Which claims count as one of a family of tests.
enum class ClaimKind : std::uint8_t {
  tested,       // its probability is corrected for how many are tested (Holm 1979)
  join_names,   // decided by what is listed whole: no probability
  contradicts,  // by the paper's own numbers
  untestable,   // here; `why` says what would have to be
};
template <>
inline constexpr std::array words<ClaimKind>{"tested", "listed", "contradicts", "untestable"};

struct PaperClaim {
  std::string id, where, text, printed;
  ClaimKind kind = ClaimKind::tested;
  std::string study = {};  // of words<PaperStudy>: the repetition whose results it is judged by
  std::optional<ClaimBound> bound = {};
  std::string why = {};  // this margin
  std::vector<ClaimedNumber> numbers = {};

  static void fields(PaperClaim& self, Fields& f);
};

// Effect of an erratum on errors: the method as printed against the corrected one.
struct ErratumEffect {
  std::string id, study;
  std::vector<ClaimedNumber> numbers;

  static void fields(ErratumEffect& self, Fields& f);
};

// claims.json, which is in the program.
std::span<const PaperClaim> paper_claims();
std::span<const ErratumEffect> erratum_effects();

// The keys of all numbers of claims and errata of such a repetition of the paper.
std::vector<NumberKey> claimed_keys(const std::string& paper);
// The methods that they compare others with.
std::vector<std::string> compared_with(const std::string& paper);

}  // namespace trilat
