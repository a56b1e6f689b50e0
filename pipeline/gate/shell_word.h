// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace trilat {

// Text that a shell takes as one word: as it is when that is plain, else in single quotes.
std::string shell_word(const std::string& text);

}  // namespace trilat
