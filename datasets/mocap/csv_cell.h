// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "datasets/base/units.h"

namespace trilat {

// The cells of one CSV line, without quotes and the blanks around them.
std::vector<std::string> split_csv(std::string_view line);

enum class CellKind { number, empty, not_finite, unreadable };

// A data cell with all its spellings: blanks, quotes, NAN, -1.#IND0000, infinity. Anything but a number
// leaves `value` undefined.
CellKind parse_cell(std::string_view text, double& value);

// An integer cell; false when it is anything else.
bool parse_integer(std::string_view text, std::int64_t& value);

// The end of the cell that starts at `p`: its comma, or `end`.
const char* end_of_cell(const char* p, const char* end);

inline constexpr std::array<double, 16> kPowersOfTen{1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                     1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

// A plain decimal such as -12.345678 of at most 15 digits up to a comma or `end`; returns its end, or nullptr
// for any other text. Exact: an integer below 2^53 divided by an exact power of ten is rounded once.
inline const char* parse_plain_decimal(const char* p, const char* end, double& value) {
  const bool negative = p != end && *p == '-';
  if (negative) ++p;
  const char* const start = p;
  std::uint64_t digits = 0;  // may wrap; `count` tells
  const auto take_digits = [&] {
    for (unsigned digit; p != end && (digit = static_cast<unsigned char>(*p) - unsigned{'0'}) < 10; ++p)
      digits = digits * 10 + digit;
  };
  take_digits();
  std::ptrdiff_t count = p - start;
  std::ptrdiff_t decimals = 0;
  if (p != end && *p == '.') {
    const char* const point = ++p;
    take_digits();
    decimals = p - point;
    count += decimals;
  }
  if (count == 0 || count > 15 || (p != end && *p != ',')) return nullptr;
  const double magnitude = static_cast<double>(digits) / kPowersOfTen[static_cast<std::size_t>(decimals)];
  value = negative ? -magnitude : magnitude;
  return p;
}

using HeaderValues = std::map<std::string, std::string, std::less<>>;

// The keys of an export's header and what stands behind them. InputError at `place` with the key where a
// value is not what it must be.
class HeaderKeys {
 public:
  HeaderKeys(HeaderValues values, std::string place) : values_(std::move(values)), place_(std::move(place)) {}

  // Empty when the key is not there.
  std::string text(std::string_view key) const;
  std::optional<std::int64_t> count(std::string_view key) const;
  // 0 to `most`.
  std::int64_t stated_count(std::string_view key, std::int64_t most) const;
  // 1 to 9000 Hz; NaN when it is not stated.
  double rate_hz(std::string_view key) const;
  double stated_rate_hz(std::string_view key) const;
  LengthUnit length_unit(std::string_view key) const;

 private:
  [[noreturn]] void refuse(std::string_view key, const std::string& right) const;

  HeaderValues values_;
  std::string place_;
};

}  // namespace trilat
