// SPDX-License-Identifier: MIT
#include "datasets/base/error.h"

#include <string>

namespace trilat {

std::string printable(std::string_view text) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string shown;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte >= 0x20 && byte != 0x7f) || c == '\n' || c == '\t')
      shown += c;
    else
      shown += {'\\', 'x', kDigits[byte >> 4U], kDigits[byte & 15U]};
  }
  return shown;
}

InputError::InputError(std::string place, std::string problem)
    : std::runtime_error(printable(place + ": " + problem)),
      place_(printable(place)),
      problem_(printable(problem)) {}

void check_failed(const char* file, int line, const char* what) {
  const std::string path = file;
  const auto slash = path.find_last_of('/');
  throw InternalError(path.substr(slash == std::string::npos ? 0 : slash + 1) + ":" + std::to_string(line) +
                      ": " + what);
}

}  // namespace trilat
