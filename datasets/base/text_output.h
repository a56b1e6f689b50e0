// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace trilat {

// A field of a CSV file as RFC 4180 has it: between quotes where a comma, a quote or the end of a line stands
// in it, with quotes doubled. Everything that writes CSV writes texts with it.
std::string csv_field(std::string_view text);
// Cell of a CSV, always between quotes.
std::string csv_quoted(std::string_view text);
// The fields of one record, without their quotes.
std::vector<std::string> csv_fields(std::string_view record);
// Calls `read(place, record)` for each record of a file's text, where place is "FILE:NUMBER" and the end of
// line, which may be that of Windows, is taken off. InputError when the last record has no end of line: its
// last number may be cut, and look like a number.
void for_each_csv_record(
    const std::string& file, std::string_view text,
    const std::function<void(const std::string& place, const std::string& record)>& read);
// Text that a shell takes as one word: as it is when that is plain, else in single quotes.
std::string shell_word(std::string_view text);

// A file of any length that is written aside and gets its name by publish(); without that nothing is left.
// OutputError with the path when the disk does not let us.
class TextOutput {
 public:
  explicit TextOutput(const std::filesystem::path& path);
  ~TextOutput();
  TextOutput(const TextOutput&) = delete;
  TextOutput& operator=(const TextOutput&) = delete;

  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
    if (text_.size() > kBlockBytes) write_block();
  }
  // Bytes as they are.
  void add_bytes(std::string_view bytes) {
    text_ += bytes;
    if (text_.size() > kBlockBytes) write_block();
  }
  void publish();

 private:
  static constexpr std::size_t kBlockBytes = 1u << 16;
  void write_block();

  std::filesystem::path path_;
  std::FILE* file_ = nullptr;
  std::string text_;
};

}  // namespace trilat
