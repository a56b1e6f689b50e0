// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "datasets/base/error.h"
#include "datasets/base/time.h"
#include "datasets/base/units.h"

namespace trilat {

// Lines of a text file of any length, read in blocks. Memory is bounded by one block and the longest line
// allowed, 16 MiB.
class LineReader {
 public:
  // InputError when the file cannot be opened.
  LineReader(const std::filesystem::path& path, std::size_t block_bytes);
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  // The next line without its line ending; valid until the next call. False at the end.
  bool next(std::string_view& line);
  // Whether the line had its newline: only the file's last one may have none.
  bool terminated() const { return terminated_; }
  // "take.csv:17", the line that was read last.
  std::string place() const;

  // Puts the line read last back; once, before anything else is read.
  void put_back();

 private:
  void refill();

  std::string path_;
  int file_ = -1;
  std::size_t block_bytes_;
  std::vector<char> buffer_;
  std::size_t line_begin_ = 0;  // of the line read last
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool at_end_ = false;
  bool terminated_ = true;
  std::int64_t line_ = 0;
};

// Beyond 100 m no position of a room-sized tracking system makes sense: most often the header states another
// unit than the numbers have.
inline constexpr double kMaxDistance_m = 100.0;
inline constexpr const char* kTooFar =
    "is more than 100 m; have the numbers another unit than the header says?";
// The numbers of a file that are too far. One value again and again stands for what is missing, such as 1e6;
// two that differ, or one that comes once, make no sense.
class FarNumbers {
 public:
  // `refusal()` makes the InputError of the number's place; that of the first one is thrown when another
  // value comes.
  template <class Refusal>
  void add(double number, const Refusal& refusal) {
    if (count_ > 0 && number != number_) throw *first_;
    if (count_++ > 0) return;
    number_ = number;
    first_ = refusal();
  }
  // At the end of the file: throws the refusal of a number that came once.
  void end() const {
    if (count_ == 1) throw *first_;
  }

 private:
  std::int64_t count_ = 0;
  double number_ = 0.0;
  std::optional<InputError> first_;
};

// Larger frame numbers and counts are refused.
inline constexpr std::int64_t kHighestFrame = 1'000'000'000;
// 30 years: no clock of a take shows more.
inline constexpr double kLatest_s = 1e9;

// Whether it is in the range of motion capture systems, 1 Hz to 9 kHz.
bool is_frame_rate(double rate_hz);

// round(frames / rate), exact in integers; the rate in millionths of a hertz, 1 Hz to 9 kHz.
Duration duration_of_frames(std::int64_t frames, std::int64_t rate_uhz);

// The cells of one CSV line, without quotes and the blanks around them.
std::vector<std::string> split_csv(std::string_view line);

// InputError where a file's lines end as those of old Macs, so that the whole file is its first line.
void refuse_lone_returns(std::string_view first_line, const std::string& place);

enum class CellKind { number, empty, not_finite, unreadable };

// A data cell with all its spellings: blanks, quotes, NAN, NA, -1.#IND0000, infinity. Anything but a number
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
  LengthUnit length_unit(std::string_view key) const;

 private:
  [[noreturn]] void refuse(std::string_view key, const std::string& right) const;

  HeaderValues values_;
  std::string place_;
};

}  // namespace trilat
