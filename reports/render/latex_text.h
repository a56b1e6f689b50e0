// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace trilat {

// Text as LaTeX sets it, with T1 fonts and any engine: markup escaped, signs as commands, and a character
// that T1 has not as its number, [U+6D4B], so that a document compiles whatever names it holds.
std::string latex_text(const std::string& text);

// The same for a narrow column: long words may break behind their punctuation.
std::string latex_breakable(const std::string& text);

}  // namespace trilat
