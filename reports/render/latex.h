// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "reports/tables/table.h"

namespace trilat {

// Text as LaTeX sets it, with T1 fonts and any engine: markup escaped, signs as commands, and a character
// that T1 has not as its number, [U+6D4B], so that a document compiles whatever names it holds.
std::string latex_text(const std::string& text);

// A longtable that needs the packages booktabs and longtable and nothing else.
std::string latex_of(const Table& table);

// One number of a table as a LaTeX macro.
struct ArticleNumber {
  std::string name;   // letters only, without the backslash
  std::string value;  // as printed in the table, or "low to high" of an interval
};

// Every number of every table, in their order. A name is "trilat" and the words of the table's id, the row
// and the column's key, each with a capital: table3, nonlinear at the wrist, mae_cm make
// \trilatTableThreeWristNonlinearMaeCm. Digits are written out, all but letters and digits only parts words.
// The row is named by the shortest run of its first cells that tells all rows of the table apart, or by its
// number. A number followed by its 95 % interval (columns …_from… and …_to…) has a second macro …Interval.
// Names that would be equal get Second, Third, …
std::vector<ArticleNumber> article_numbers(const std::vector<Table>& tables);

// numbers.tex: to be \input before the text. What is not a number is a dash.
std::string latex_of(const std::vector<ArticleNumber>& numbers);

// "table 3: MAE" -> "TableThreeMAE"
std::string macro_words(const std::string& text);

}  // namespace trilat
