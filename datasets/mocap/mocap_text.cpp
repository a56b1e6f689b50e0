// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_text.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include <fcntl.h>
#include <unistd.h>

#include "datasets/base/text_output.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxLineLength = 16u << 20;

constexpr std::int64_t kMicrohertz = 1'000'000;
constexpr std::int64_t kHighestRate_uhz = 9000 * kMicrohertz;
constexpr std::int64_t kMaxFrames = 2'000'000'000;

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string_view bare(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    text = trimmed(text.substr(1, text.size() - 2));
  return text;
}

// Whether a cell says that a value is missing: NA, None and so on in R, Excel, Python and JavaScript;
// 1.#IND0000, 1.#QNAN or 1.#INF in old C libraries, some of which drop the "1.".
bool spells_not_a_number(std::string_view text) {
  for (std::string_view word : {"NA", "N/A", "#N/A", "None", "null"})
    if (text == word) return true;
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  if (text.starts_with("1.#")) text.remove_prefix(2);
  for (std::string_view word : {"#IND", "#QNAN", "#SNAN", "#INF"})
    if (text.starts_with(word)) return true;
  return false;
}

}  // namespace

LineReader::LineReader(const std::filesystem::path& path, std::size_t block_bytes)
    : path_(path.string()), block_bytes_(std::max<std::size_t>(1, block_bytes)) {
  file_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) throw InputError(path_, std::string("cannot be opened: ") + std::strerror(errno));
}

LineReader::~LineReader() { ::close(file_); }

std::string LineReader::place() const {
  return path_ + ":" + std::to_string(std::max<std::int64_t>(1, line_));
}

void LineReader::put_back() {
  begin_ = line_begin_;
  --line_;
}

void LineReader::refill() {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (end_ > kMaxLineLength) {
    ++line_;
    throw InputError(place(), "is a line longer than 16 MiB; this is not a text file of rows");
  }
  if (buffer_.size() - end_ < block_bytes_)
    buffer_.resize(std::max(end_ + block_bytes_, std::min(2 * end_, kMaxLineLength)));
  ssize_t count = 0;
  do {
    count = ::read(file_, buffer_.data() + end_, block_bytes_);
  } while (count < 0 && errno == EINTR);
  if (count < 0) throw InputError(path_, std::string("cannot be read: ") + std::strerror(errno));
  at_end_ = count == 0;
  end_ += static_cast<std::size_t>(count);
}

bool LineReader::next(std::string_view& line) {
  std::size_t searched = 0;
  const void* newline = nullptr;
  while (true) {
    const char* start = buffer_.data() + begin_;
    const std::size_t size = end_ - begin_;
    newline = size > searched ? std::memchr(start + searched, '\n', size - searched) : nullptr;
    if (newline || at_end_) break;
    searched = size;
    refill();
  }
  const char* start = buffer_.data() + begin_;
  terminated_ = newline != nullptr;
  if (!terminated_ && begin_ == end_) return false;
  const std::size_t size =
      terminated_ ? static_cast<std::size_t>(static_cast<const char*>(newline) - start) : end_ - begin_;
  line_begin_ = begin_;
  begin_ += size + (terminated_ ? 1 : 0);
  ++line_;
  line = std::string_view(start, size);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return true;
}

bool is_frame_rate(double rate_hz) { return rate_hz >= 1.0 && rate_hz <= 9000.0; }

Duration duration_of_frames(std::int64_t frames, std::int64_t rate_uhz) {
  TRILAT_CHECK(rate_uhz >= kMicrohertz && rate_uhz <= kHighestRate_uhz, "the rate is in range");
  TRILAT_CHECK(frames >= 0 && frames <= kMaxFrames, "the frame count is in range");
  // 2e9 s, and a remainder below 9e9, times 1e9 still fit.
  const std::int64_t ticks = frames * kMicrohertz;
  const std::int64_t rest = ticks % rate_uhz;
  return {ticks / rate_uhz * kNsPerSecond + (rest * kNsPerSecond + rate_uhz / 2) / rate_uhz};
}

std::vector<std::string> split_csv(std::string_view line) {
  std::vector<std::string> cells = csv_fields(line);
  for (std::string& cell : cells) cell = trimmed(cell);
  return cells;
}

void refuse_lone_returns(std::string_view first_line, const std::string& place) {
  if (first_line.substr(0, first_line.find_last_not_of('\r') + 1).find('\r') != std::string_view::npos)
    throw InputError(place, "ends its lines by carriage returns alone; save it with line feeds");
}

CellKind parse_cell(std::string_view text, double& value) {
  text = bare(text);
  if (text.empty()) return CellKind::empty;
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && rest == text.data() + text.size())
    return std::isfinite(value) ? CellKind::number : CellKind::not_finite;
  return spells_not_a_number(text) ? CellKind::not_finite : CellKind::unreadable;
}

bool parse_integer(std::string_view text, std::int64_t& value) {
  text = bare(text);
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && rest == text.data() + text.size();
}

const char* end_of_cell(const char* p, const char* end) {
  bool quoted = false;
  for (; p != end; ++p) {
    if (*p == '"') quoted = !quoted;
    if (*p == ',' && !quoted) return p;
  }
  return end;
}

std::string HeaderKeys::text(std::string_view key) const {
  const auto found = values_.find(key);
  return found == values_.end() ? std::string() : found->second;
}

std::optional<std::int64_t> HeaderKeys::count(std::string_view key) const {
  const std::string cell = text(key);
  std::int64_t value = 0;
  if (cell.empty()) return std::nullopt;
  if (!parse_integer(cell, value)) refuse(key, "an integer");
  return value;
}

std::int64_t HeaderKeys::stated_count(std::string_view key, std::int64_t most) const {
  const auto value = count(key);
  if (!value || *value < 0 || *value > most) refuse(key, "an integer from 0 to " + std::to_string(most));
  return *value;
}

double HeaderKeys::rate_hz(std::string_view key) const {
  const std::string cell = text(key);
  double value = kNaN;
  if (cell.empty()) return value;
  if (parse_cell(cell, value) != CellKind::number || !is_frame_rate(value))
    refuse(key, "a rate of 1 to 9000 Hz, such as 120.000000");
  return value;
}

LengthUnit HeaderKeys::length_unit(std::string_view key) const {
  const auto unit = length_unit_from_text(text(key));
  if (!unit) refuse(key, "Meters, Centimeters, Millimeters, Inches or Feet");
  return *unit;
}

void HeaderKeys::refuse(std::string_view key, const std::string& right) const {
  const std::string cell = text(key);
  throw InputError(place_, "\"" + std::string(key) + "\" is " +
                               (cell.empty() ? "not stated" : "\"" + cell + "\"") + "; it must be " + right);
}

}  // namespace trilat
