// SPDX-License-Identifier: MIT
#include "datasets/mocap/line_reader.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/units.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxLineLength = 16u << 20;

constexpr std::int64_t kMicrohertz = 1'000'000;
constexpr std::int64_t kHighestRate_uhz = 9000 * kMicrohertz;
constexpr std::int64_t kMaxFrames = 2'000'000'000;

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

void LineReader::unread() {
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

}  // namespace trilat
