// SPDX-License-Identifier: MIT
#include "datasets/import/json_elements.h"

#include <cerrno>
#include <cstring>

#include "datasets/base/error.h"
#include "datasets/import/import_types.h"

namespace trilat {
namespace {

constexpr std::size_t kLongestElement = 1u << 20;
constexpr int kEnd = std::char_traits<char>::eof();

}  // namespace

JsonElements::JsonElements(const std::filesystem::path& path)
    : path_(path.string()), stream_(path, std::ios::binary) {
  if (!stream_) throw InputError(path_, std::string("cannot be opened: ") + std::strerror(errno));
  const int c = get_past_blanks();
  if (c != '[') throw InputError(place(), "does not begin with '['; a JSON array of bodies is expected");
}

std::string JsonElements::place() const {
  return path_ + ":" + std::to_string(begin_line_) + " (byte " + std::to_string(begin_) + ")";
}

int JsonElements::get() {
  const int c = stream_.rdbuf()->sbumpc();
  if (c == kEnd) return c;
  ++byte_;
  if (c == '\n') ++line_;
  return c;
}

int JsonElements::get_past_blanks() {
  int c = get();
  while (c == ' ' || c == '\n' || c == '\r' || c == '\t') c = get();
  begin_ = byte_ > 0 ? byte_ - 1 : 0;
  begin_line_ = line_;
  return c;
}

bool JsonElements::next(std::string& text) {
  if (ended_) return false;
  int c = get_past_blanks();
  if (!first_ && c == ',') c = get_past_blanks();
  first_ = false;
  ended_ = c != '{';
  if (c == ']') return false;
  if (c == kEnd) throw TornRow{"is where the file ends, before the array is closed"};
  if (c != '{') throw InputError(place(), "is no object; an array of bodies is expected");
  text.clear();
  int depth = 0;
  bool quoted = false, escaped = false;
  for (; c != kEnd; c = get()) {
    if (text.size() >= kLongestElement)
      throw InputError(place(), "is longer than 1 MiB; a body is much shorter");
    text += static_cast<char>(c);
    if (quoted) {
      if (!escaped && c == '"') quoted = false;
      escaped = !escaped && c == '\\';
      continue;
    }
    quoted = c == '"';
    if (c == '{') ++depth;
    if (c == '}' && --depth == 0) return true;
  }
  ended_ = true;
  throw TornRow{"is an object in which the file ends"};
}

}  // namespace trilat
