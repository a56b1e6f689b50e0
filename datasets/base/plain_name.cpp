// SPDX-License-Identifier: MIT
#include "datasets/base/plain_name.h"

#include <algorithm>

namespace trilat {

bool is_plain_name(std::string_view text) {
  return !text.empty() && text.size() <= 100 && text[0] != '.' &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
                  c == '_' || c == '.';
         });
}

}  // namespace trilat
