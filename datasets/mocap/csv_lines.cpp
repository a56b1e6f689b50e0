// SPDX-License-Identifier: MIT
#include "datasets/mocap/csv_lines.h"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::size_t kLongestLine = 16u << 20;

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

}  // namespace

CsvLines::CsvLines(const std::filesystem::path& path, std::size_t block_bytes)
    : path_(path.string()), file_(std::fopen(path.c_str(), "rb"), std::fclose), block_bytes_(block_bytes) {
  if (!file_) throw InputError(path_, std::string("cannot be opened: ") + std::strerror(errno));
}

std::string CsvLines::place() const { return path_ + ":" + std::to_string(line_number_); }

bool CsvLines::fill() {
  if (at_end_) return false;
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (end_ > kLongestLine)
    throw InputError(path_ + ":" + std::to_string(line_number_ + 1),
                     "is longer than any line of an export (16 MiB)");
  if (buffer_.size() < end_ + block_bytes_) buffer_.resize(end_ + block_bytes_);
  const std::size_t count = std::fread(buffer_.data() + end_, 1, block_bytes_, file_.get());
  if (count == 0 && std::ferror(file_.get())) throw InputError(path_, "cannot be read to its end");
  end_ += count;
  at_end_ = count == 0;
  return count > 0;
}

bool CsvLines::next(std::string_view& line) {
  std::size_t searched = 0;
  const char* newline = nullptr;
  while (true) {
    newline = end_ > begin_ + searched
                  ? static_cast<const char*>(
                        std::memchr(buffer_.data() + begin_ + searched, '\n', end_ - begin_ - searched))
                  : nullptr;
    if (newline) break;
    searched = end_ - begin_;
    if (!fill()) break;
  }
  if (!newline && begin_ == end_) return false;
  const char* start = buffer_.data() + begin_;
  std::size_t length = newline ? static_cast<std::size_t>(newline - start) : end_ - begin_;
  begin_ += length + (newline ? 1 : 0);
  ended_ = newline != nullptr;
  if (length > 0 && start[length - 1] == '\r') --length;
  line = {start, length};
  ++line_number_;
  if (line.find('\0') != std::string_view::npos)
    throw InputError(place(), "holds binary data; an export is text");
  return true;
}

std::vector<std::string> csv_fields(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  for (std::string& field : fields) field = std::string(trimmed(field));
  return fields;
}

std::string_view CsvCells::next() {
  if (ended_) return {};
  const std::size_t quote =
      !rest_.empty() && rest_.front() == '"' ? rest_.find('"', 1) : std::string_view::npos;
  const std::size_t comma = rest_.find(',', quote == std::string_view::npos ? 0 : quote);
  std::string_view cell = rest_.substr(0, comma);
  ended_ = comma == std::string_view::npos;
  if (!ended_) rest_.remove_prefix(comma + 1);
  cell = trimmed(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
    cell = trimmed(cell.substr(1, cell.size() - 2));
  return cell;
}

void CsvCells::skip(std::size_t cells) {
  const char* at = rest_.data();
  const char* const end = at + rest_.size();
  for (; cells > 0 && !ended_; --cells) {
    const void* comma = at < end ? std::memchr(at, ',', static_cast<std::size_t>(end - at)) : nullptr;
    ended_ = comma == nullptr;
    at = ended_ ? end : static_cast<const char*>(comma) + 1;
  }
  rest_ = {at, static_cast<std::size_t>(end - at)};
}

CellKind parse_cell(std::string_view cell, double& value) {
  if (cell.empty()) return CellKind::empty;
  if (cell.front() == '+') cell.remove_prefix(1);
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error == std::errc() && end == cell.data() + cell.size())
    return std::isfinite(value) ? CellKind::number : CellKind::not_finite;
  if (cell.find('#') != std::string_view::npos) return CellKind::not_finite;  // 1.#QNAN, -1.#IND0000
  if (error == std::errc::result_out_of_range) return CellKind::not_finite;
  return CellKind::text;
}

}  // namespace trilat
