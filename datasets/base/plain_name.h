// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace trilat {

// Whether a text can be the name of a file or folder anywhere: 1 to 100 letters, digits, '-', '_' or '.', not
// starting with '.'.
bool is_plain_name(std::string_view text);

}  // namespace trilat
