// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/results/table.h"

namespace trilat {

// Text as LaTeX sets it, with T1 fonts and any engine: markup escaped, signs as commands, and a character
// that T1 has not as its number, [U+6D4B], so that a document compiles whatever names it holds.
std::string latex_text(const std::string& text);

// A longtable that needs the packages booktabs and longtable and nothing else.
std::string latex_of(const Table& table);

}  // namespace trilat
