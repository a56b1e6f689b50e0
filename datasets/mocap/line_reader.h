// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/base/error.h"
#include "datasets/base/time.h"

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
  void unread();

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

// A frame number or count beyond it is none.
inline constexpr std::int64_t kHighestFrame = 1'000'000'000;
// 30 years: no clock of a take shows more.
inline constexpr double kLatest_s = 1e9;

// Whether it is in the range of motion capture systems, 1 Hz to 9 kHz.
bool is_frame_rate(double rate_hz);

// round(frames / rate), exact in integers; the rate in millionths of a hertz, 1 Hz to 9 kHz.
Duration duration_of_frames(std::int64_t frames, std::int64_t rate_uhz);

}  // namespace trilat
