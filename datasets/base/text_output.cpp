// SPDX-License-Identifier: MIT
#include "datasets/base/text_output.h"

#include <cerrno>
#include <cstring>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {

std::string csv_field(std::string_view text) {
  return text.find_first_of(",\"\r\n") == std::string_view::npos ? std::string(text) : csv_quoted(text);
}

std::string csv_quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::vector<std::string> csv_fields(std::string_view record) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < record.size(); ++i) {
    const char c = record[i];
    if (c == '"' && quoted && i + 1 < record.size() && record[i + 1] == '"') {
      fields.back() += record[++i];
    } else if (c == '"' && (quoted || fields.back().empty())) {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

void for_each_csv_record(const std::string& file, std::string_view text,
                         const std::function<void(const std::string&, const std::string&)>& read) {
  std::size_t number = 0, first = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') quoted = !quoted;
    if (text[i] != '\n' || quoted) continue;
    std::string_view record = text.substr(first, i - first);
    if (record.ends_with('\r')) record.remove_suffix(1);
    read(fmt::format("{}:{}", file, ++number), std::string(record));
    first = i + 1;
  }
  if (first < text.size())
    throw InputError(fmt::format("{}:{}", file, number + 1), "is cut: the line has no end");
}

std::string shell_word(std::string_view text) {
  const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string_view::npos) return std::string(text);
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

TextOutput::TextOutput(const std::filesystem::path& path) : path_(path) {
  check_output_file(path);
  file_ = std::fopen(partial_name(path).c_str(), "wb");
  if (!file_) throw OutputError(path.string(), std::string("cannot be written: ") + std::strerror(errno));
}

TextOutput::~TextOutput() {
  if (!file_) return;
  std::fclose(file_);
  std::error_code ignored;
  std::filesystem::remove(partial_name(path_), ignored);
}

void TextOutput::write_block() {
  if (std::fwrite(text_.data(), 1, text_.size(), file_) != text_.size())
    throw OutputError(path_.string(), std::string("cannot be written: ") + std::strerror(errno));
  text_.clear();
}

void TextOutput::publish() {
  write_block();
  std::FILE* const file = std::exchange(file_, nullptr);
  if (std::fclose(file) != 0)
    throw OutputError(path_.string(), std::string("cannot be written: ") + std::strerror(errno));
  publish_file(partial_name(path_), path_);
}

}  // namespace trilat
