// SPDX-License-Identifier: MIT
#include "evaluators/metrics/quantile_selection.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "datasets/base/check.h"

namespace trilat {
namespace {

constexpr int kDigitBits = 11;
constexpr int kFirstShift = 55;  // digits at 55, 44, 33, 22, 11, 0; the first one has 9 bits
constexpr std::uint64_t kDigitMask = (1u << kDigitBits) - 1u;

std::uint64_t above_digit(std::uint64_t bits, int shift) {
  return shift == kFirstShift ? 0 : bits >> (shift + kDigitBits);
}

}  // namespace

QuantileSelection::QuantileSelection(std::vector<double> quantiles)
    : wanted_(std::move(quantiles)), shift_(kFirstShift) {
  for (const double q : wanted_) TRILAT_CHECK(q >= 0.0 && q <= 1.0, "a quantile is in [0, 1]");
  prefixes_.push_back({0, std::vector<std::int64_t>(kDigitMask + 1)});
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
  if (prefix) ++prefix->histogram[(bits >> shift_) & kDigitMask];
}

void QuantileSelection::merge_pass(const QuantileSelection& later) {
  TRILAT_CHECK(
      shift_ == later.shift_ && wanted_ == later.wanted_ && prefixes_.size() == later.prefixes_.size(),
      "only the same pass of the same selection merges");
  shown_ += later.shown_;
  for (std::size_t p = 0; p < prefixes_.size(); ++p) {
    TRILAT_CHECK(prefixes_[p].bits == later.prefixes_[p].bits, "both follow the same values");
    for (std::size_t d = 0; d <= kDigitMask; ++d)
      prefixes_[p].histogram[d] += later.prefixes_[p].histogram[d];
  }
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

void QuantileSelection::settle_digit(Rank& rank) const {
  const std::uint64_t above = above_digit(rank.bits, shift_);
  const auto prefix =
      std::find_if(prefixes_.begin(), prefixes_.end(), [&](const Prefix& p) { return p.bits == above; });
  TRILAT_CHECK(prefix != prefixes_.end(), "every rank has a prefix");
  std::uint64_t digit = 0;
  while (digit < kDigitMask && rank.within >= prefix->histogram[digit])
    rank.within -= prefix->histogram[digit++];
  TRILAT_CHECK(rank.within < prefix->histogram[digit], "every pass shows the same values");
  rank.bits |= digit << shift_;
}

void QuantileSelection::open_prefixes() {
  prefixes_.clear();
  if (done()) return;
  for (const Rank& rank : ranks_) {
    const std::uint64_t above = above_digit(rank.bits, shift_);
    if (!find_prefix(above)) prefixes_.push_back({above, std::vector<std::int64_t>(kDigitMask + 1)});
  }
}

void QuantileSelection::end_pass() {
  TRILAT_CHECK(!done(), "a pass ends before the end");
  if (shift_ == kFirstShift) start_ranks();
  TRILAT_CHECK(shown_ == count_, "every pass shows the same values");
  for (Rank& rank : ranks_) settle_digit(rank);
  shift_ = count_ == 0 ? -1 : shift_ - kDigitBits;
  shown_ = 0;
  open_prefixes();
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
