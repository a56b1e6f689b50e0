// SPDX-License-Identifier: MIT
#include "datasets/base/philox.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/base/error.h"

namespace trilat {
namespace {

std::array<std::uint32_t, 4> block_of(const RandomStream& stream, std::uint32_t index) {
  return philox4x32_10(
      {index, static_cast<std::uint32_t>(stream.item), static_cast<std::uint32_t>(stream.item >> 32),
       static_cast<std::uint32_t>(stream.purpose)},
      {static_cast<std::uint32_t>(stream.seed), static_cast<std::uint32_t>(stream.seed >> 32)});
}

}  // namespace

double open_unit(std::uint32_t low, std::uint32_t high) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(high) << 32 | low) >> 11;
  constexpr double kMaxValue = 1.0 - 0x1p-53;  // the sum of the largest bits rounds up to 1
  return std::min((static_cast<double>(bits) + 0.5) * 0x1p-53, kMaxValue);
}

std::array<std::uint32_t, 4> philox4x32_10(std::array<std::uint32_t, 4> counter,
                                           std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53} * counter[0];
    const std::uint64_t b = std::uint64_t{0xCD9E8D57} * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key[0] += 0x9E3779B9;
    key[1] += 0xBB67AE85;
  }
  return counter;
}

double RandomStream::uniform(std::uint32_t index) const {
  const auto block = block_of(*this, index);
  return open_unit(block[0], block[1]);
}

double RandomStream::normal(std::uint32_t index) const { return normal_pair(index)[0]; }

std::array<double, 2> RandomStream::normal_pair(std::uint32_t index) const {
  const auto block = block_of(*this, index);
  const double radius = std::sqrt(-2.0 * std::log(open_unit(block[0], block[1])));
  const double angle = 2.0 * std::numbers::pi * open_unit(block[2], block[3]);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

std::uint64_t random_item(std::uint64_t take, std::uint64_t unit, std::uint64_t part, std::uint64_t step) {
  TRILAT_CHECK(take < (1u << 14) && unit < (1u << 10) && part < (1u << 8) && step < (1ull << 32),
               "a random item lies within its bounds");
  return take << 50 | unit << 40 | part << 32 | step;
}

}  // namespace trilat
