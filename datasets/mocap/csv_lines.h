// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace trilat {

// The lines of a text file, read in blocks. Bounded: a line longer than 16 MiB is refused.
class CsvLines {
 public:
  explicit CsvLines(const std::filesystem::path& path, std::size_t block_bytes = 1u << 20);
  // The next line without its end (LF or CRLF); false at the end. Valid until the next call.
  bool next(std::string_view& line);
  std::uint64_t line_number() const { return line_number_; }
  // Whether the line last given ended with a line end, not with the file.
  bool line_was_ended() const { return ended_; }
  std::string place() const;  // "take.csv:17"
  const std::string& path() const { return path_; }

 private:
  bool fill();
  std::string path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::vector<char> buffer_;
  std::size_t block_bytes_, begin_ = 0, end_ = 0;
  std::uint64_t line_number_ = 0;
  bool at_end_ = false, ended_ = true;
};

// Splits one line of RFC 4180 CSV; quotes are taken off.
std::vector<std::string> csv_fields(std::string_view line);

// Reads the cells of a line of numbers from left to right, without copying.
class CsvCells {
 public:
  explicit CsvCells(std::string_view line) : rest_(line) {}
  bool at_end() const { return ended_; }
  // The next cell, quotes and spaces around it taken off; empty behind the last one.
  std::string_view next();
  void skip(std::size_t cells);

 private:
  std::string_view rest_;
  bool ended_ = false;
};

// What a cell of a number holds.
enum class CellKind { empty, number, not_finite, text };
CellKind parse_cell(std::string_view cell, double& value);

}  // namespace trilat
