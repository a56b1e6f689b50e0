// SPDX-License-Identifier: MIT
#include "reports/table.h"

#include <algorithm>

namespace trilat {

std::string usable_id(std::string text) {
  const auto is_kept = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  std::replace_if(
      text.begin(), text.end(), [&](char c) { return !is_kept(c); }, '-');
  return text;
}

}  // namespace trilat
