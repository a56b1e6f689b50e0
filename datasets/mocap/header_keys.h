// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "datasets/base/units.h"

namespace trilat {

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
