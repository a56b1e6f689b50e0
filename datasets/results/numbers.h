// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "datasets/base/units.h"

namespace trilat {

// Key of a number of a study. A part that does not apply is empty.
struct NumberKey {
  std::string condition = {};  // the takes' activity, or occluded_condition() of it
  std::string group = {};      // a joint group, kAverageGroup, kBodyGroup; of one take a joint
  std::string method = {}, against = {};
  std::string alignment = {};
  std::string measure = {};    // "distance", "x", "answered": units are those of unit_of()
  std::string statistic = {};  // "mean", "median", "share"
  std::string take = {};       // empty: all takes of the condition

  bool operator==(const NumberKey&) const = default;
  // The same key with the parts that `more` has.
  NumberKey with(const NumberKey& more) const;
};

// One number with its 95 % interval, in SI units. NaN where there is none.
struct Number : NumberKey {
  double value = kNaN, low = kNaN, high = kNaN;
  std::uint64_t n = 0;         // samples behind it
  std::uint64_t clusters = 0;  // behind its interval
  double p = kNaN;             // p value of a difference from zero, two-sided
};

// The measures along the world's axes.
inline constexpr std::array kAxisNames{"x", "y", "z"};

// All numbers of a study, each key once.
class Numbers {
 public:
  // Numbers that are not finite, as ratios to an error of 0, are left out. A key that is there already is our
  // bug.
  void add(Number number);
  void add(const Numbers& more);
  // The number of that key, or null.
  const Number* find(const NumberKey& key) const;
  double value(const NumberKey& key) const;
  std::uint64_t n(const NumberKey& key) const;  // 0 where there is no such number
  std::span<const Number> all() const { return numbers_; }

 private:
  struct Hash {
    std::size_t operator()(const NumberKey& key) const;
  };
  std::vector<Number> numbers_;
  std::unordered_map<NumberKey, std::size_t, Hash> places_;
};

// "m", "rad", "s", "m/s3", "steps", or "1" for shares.
std::string unit_of(const NumberKey& key);

// Which way a number is worse.
enum class Better : std::uint8_t { smaller, larger, neither };
Better better_of(const NumberKey& key);

// numbers.csv (RFC 4180): condition, group, method, against, alignment, measure, statistic, take, unit,
// value, low, high, n, clusters, p. NaN is an empty cell; numbers are written so that they are read back
// exactly.
inline constexpr const char* kNumbersFile = "numbers.csv";
inline constexpr std::size_t kMaxNumbersBytes = std::size_t{1} << 30;
void write_numbers(const std::filesystem::path& folder, const Numbers& numbers);
// Reads the `expected` rows of folder/numbers.csv. InputError with the row where one is cut, repeated, or has
// another unit or no number, and where there are fewer or more.
Numbers read_numbers(const std::filesystem::path& folder, std::size_t expected);

}  // namespace trilat
