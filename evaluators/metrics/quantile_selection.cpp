// SPDX-License-Identifier: MIT
#include "evaluators/metrics/quantile_selection.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr int kDigitBits = 10;   // so that the histograms of many cells stay in the processor's caches
constexpr int kFirstShift = 51;  // digits at 51, of 12 bits, then at 41, 31, 21, 11, 1 and 0
constexpr std::int64_t kMostKept = 32768;

int bits_at(int shift) { return shift == kFirstShift ? 12 : shift == 0 ? 1 : kDigitBits; }

std::size_t digit_count(int shift) { return std::size_t{1} << bits_at(shift); }

std::uint64_t digit_of(std::uint64_t bits, int shift) { return (bits >> shift) & (digit_count(shift) - 1); }

std::uint64_t above_digit(std::uint64_t bits, int shift) {
  return shift == kFirstShift ? 0 : bits >> (shift + bits_at(shift));
}

int next_shift(int shift) { return shift == 0 ? -1 : std::max(0, shift - kDigitBits); }

}  // namespace

QuantileSelection::QuantileSelection(std::vector<double> quantiles)
    : wanted_(std::move(quantiles)), shift_(kFirstShift) {
  for (const double q : wanted_) TRILAT_CHECK(q >= 0.0 && q <= 1.0, "a quantile is in [0, 1]");
  prefixes_.push_back({0, {}, {}});
}

QuantileSelection::Prefix* QuantileSelection::find_prefix(std::uint64_t bits) {
  for (Prefix& prefix : prefixes_)
    if (prefix.bits == bits) return &prefix;
  return nullptr;
}

void QuantileSelection::add(double value) {
  TRILAT_CHECK(!done() && value >= 0.0, "a value is >= 0 and comes before the end");
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(value + 0.0);  // -0 becomes 0
  ++shown_;
  Prefix* prefix = find_prefix(above_digit(bits, shift_));
  if (!prefix) return;
  if (keeps_values_) {
    prefix->values.push_back(value + 0.0);
    return;
  }
  if (prefix->histogram.empty()) prefix->histogram.resize(digit_count(shift_));
  ++prefix->histogram[digit_of(bits, shift_)];
}

void QuantileSelection::start_ranks() {
  count_ = shown_;
  if (count_ == 0) return;
  for (const double q : wanted_) {
    const auto below = static_cast<std::int64_t>(std::floor(static_cast<double>(count_ - 1) * q));
    ranks_.push_back({below, 0});
    ranks_.push_back({std::min(below + 1, count_ - 1), 0});
  }
}

// Says how many values of this pass share the digits settled so far.
std::int64_t QuantileSelection::settle_digit(Rank& rank) const {
  const std::uint64_t above = above_digit(rank.bits, shift_);
  const auto prefix =
      std::find_if(prefixes_.begin(), prefixes_.end(), [&](const Prefix& p) { return p.bits == above; });
  TRILAT_CHECK(prefix != prefixes_.end() && !prefix->histogram.empty(), "every pass shows the same values");
  std::uint64_t digit = 0;
  while (digit + 1 < prefix->histogram.size() && rank.within >= prefix->histogram[digit])
    rank.within -= prefix->histogram[digit++];
  TRILAT_CHECK(rank.within < prefix->histogram[digit], "every pass shows the same values");
  rank.bits |= digit << shift_;
  return prefix->histogram[digit];
}

// Opens the prefixes of the next pass.
void QuantileSelection::settle_digits() {
  std::vector<Prefix> next;
  std::int64_t followed = 0;
  for (Rank& rank : ranks_) {
    const std::int64_t sharing = settle_digit(rank);
    const std::uint64_t bits = rank.bits >> shift_;
    if (std::any_of(next.begin(), next.end(), [&](const Prefix& p) { return p.bits == bits; })) continue;
    next.push_back({bits, {}, {}});
    followed += sharing;
  }
  prefixes_ = std::move(next);
  shift_ = count_ == 0 ? -1 : next_shift(shift_);
  keeps_values_ = followed <= kMostKept;
}

void QuantileSelection::settle_all() {
  for (Rank& rank : ranks_) {
    Prefix* prefix = find_prefix(above_digit(rank.bits, shift_));
    TRILAT_CHECK(prefix && rank.within < std::ssize(prefix->values), "every pass shows the same values");
    const auto wanted = prefix->values.begin() + rank.within;
    std::nth_element(prefix->values.begin(), wanted, prefix->values.end());
    rank.bits = std::bit_cast<std::uint64_t>(*wanted);
  }
  prefixes_.clear();
  shift_ = -1;
}

void QuantileSelection::end_pass() {
  TRILAT_CHECK(!done(), "a pass ends before the end");
  if (shift_ == kFirstShift) start_ranks();
  TRILAT_CHECK(shown_ == count_, "every pass shows the same values");
  if (keeps_values_)
    settle_all();
  else
    settle_digits();
  shown_ = 0;
}

std::vector<double> QuantileSelection::quantiles() const {
  TRILAT_CHECK(done(), "quantiles are known after the last pass");
  std::vector<double> result(wanted_.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < wanted_.size() && count_ > 0; ++i) {
    const double below = std::bit_cast<double>(ranks_[2 * i].bits);
    const double above = std::bit_cast<double>(ranks_[2 * i + 1].bits);
    const double position = static_cast<double>(count_ - 1) * wanted_[i];
    const double share = position - std::floor(position);
    result[i] = share == 0.0 || below == above ? below : below + share * (above - below);
  }
  return result;
}

std::vector<double> quantiles_of(std::span<const double> values, std::vector<double> quantiles) {
  QuantileSelection selection(std::move(quantiles));
  while (!selection.done()) {
    for (const double value : values) selection.add(value);
    selection.end_pass();
  }
  return selection.quantiles();
}

}  // namespace trilat
