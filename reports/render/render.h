// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/table.h"

namespace trilat {

// Characters of a text, not bytes: UTF-8 continuation bytes do not count.
std::size_t width_of(const std::string& text);

// Texts from outside may hold line breaks, which would end a row or a paragraph: spaces instead.
std::string one_line(std::string text);

// The words of a text in lines of so many characters at most; a longer word has a line of its own.
std::vector<std::string> lines_of(const std::string& text, std::size_t width);

// A value as Markdown and LaTeX print it; NaN becomes a dash.
std::string printed(const TableValue& value);
// "3.5 to 4.4"; empty where there is none.
std::string printed_interval(const TableValue& value);

// The order in which a page and an article show the columns: averages behind the names of the rows, where a
// narrow screen shows them.
std::vector<std::size_t> shown_order(const Table& table);

std::string markdown_of(const Table& table);

// Title and rows for a terminal: the first rows where a table has many, and the first and the last columns as
// they fit into so many characters. The best is marked `*` and its like `≈`; lines below say what the marks
// mean and how many rows and columns are left out.
std::string terminal_text(const Table& table, std::size_t width);

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
