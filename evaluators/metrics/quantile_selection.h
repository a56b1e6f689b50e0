// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace trilat {

// Exact quantiles of any number of values in bounded memory: the same values are shown once per
// pass, in any order. Doubles >= 0 sort like their IEEE 754 bits: the first pass settles the 12 leading
// bits of every order statistic wanted, each further one 10 more. Once at most 32768 values share the
// settled bits of those wanted, a pass keeps these and is the last; most often it is the third. 8 KiB for
// each distinct prefix, at most two a quantile, or 256 KiB of values.
//
//   while (!selection.done()) { for (x : values) selection.add(x); selection.end_pass(); }
//
// A quantile q of n values in order is x at position (n - 1) q, interpolated linearly between
// neighbours (type 7 of Hyndman and Fan 1996). Without values it is NaN.
class QuantileSelection {
 public:
  // Each quantile in [0, 1].
  explicit QuantileSelection(std::vector<double> quantiles);

  bool done() const { return shift_ < 0; }
  // InternalError for a negative value or NaN; infinity is allowed.
  void add(double value);
  // InternalError when a pass has shown another number of values than the first.
  void end_pass();

  // Values a pass.
  std::int64_t count() const { return count_; }
  // In the order asked for. InternalError before done().
  std::vector<double> quantiles() const;

 private:
  struct Prefix {
    std::uint64_t bits = 0;               // of the values it counts, from shift_ + 11 up
    std::vector<std::int64_t> histogram;  // of their next digit; none before the first value
    std::vector<double> values;           // themselves, in the last pass
  };
  struct Rank {
    std::int64_t within = 0;  // among the values that share the prefix
    std::uint64_t bits = 0;   // settled so far
  };
  void start_ranks();
  std::int64_t settle_digit(Rank& rank) const;
  void settle_digits();
  void settle_all();
  Prefix* find_prefix(std::uint64_t bits);

  std::vector<double> wanted_;
  std::vector<Rank> ranks_;  // two a quantile: below and above its position
  std::vector<Prefix> prefixes_;
  std::int64_t count_ = -1;  // not known before the first pass has ended
  std::int64_t shown_ = 0;   // in this pass
  int shift_ = 0;            // of the digit this pass settles; negative when done
  bool keeps_values_ = false;
};

// The same for values in memory.
std::vector<double> quantiles_of(std::span<const double> values, std::vector<double> quantiles);

}  // namespace trilat
