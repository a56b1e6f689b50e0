// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/results/table.h"

namespace trilat {

// Text as LaTeX sets it, with T1 fonts and any engine: markup escaped, signs as commands, and a character
// that T1 has not as its number, [U+6D4B], so that a document compiles whatever names it holds.
std::string latex_text(const std::string& text);

// A floating `tabular` that needs booktabs and nothing else, of the rows and columns in the page's order: one
// column wide (69 mm) where that is enough, else as wide as the text of an article (121 mm) or a page of two
// columns (178 mm). Values stand as value +- half of the interval; where that is too wide in the first column
// of numbers alone, or without. The first three notes stand below. Nothing where the table has more than 45
// rows, or is wider still.
std::optional<std::string> latex_of(const Table& table);

}  // namespace trilat
