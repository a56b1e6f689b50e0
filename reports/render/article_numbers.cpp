// SPDX-License-Identifier: MIT
#include "reports/render/article_numbers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "reports/render/render.h"

namespace trilat {
namespace {

constexpr std::array kDigits{"Zero", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine"};
constexpr std::array kAgain{"Second", "Third", "Fourth", "Fifth", "Sixth", "Seventh", "Eighth", "Ninth"};

bool is_command_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

std::string name_of_row(const std::vector<TableValue>& row, std::size_t cells) {
  std::string name;
  for (std::size_t c = 0; c < cells; ++c) {
    const TableValue& value = row[c];
    name += macro_words(value.number && *value.number < 0.0 ? "minus " + printed(value) : printed(value));
  }
  return name;
}

// Texts and chosen numbers at the front name a row; what was measured never does: it changes from run to run,
// and the names with it.
std::size_t naming_columns(const Table& table) {
  const auto names = [](const TableColumn& c) { return c.is_text || c.is_key; };
  return static_cast<std::size_t>(std::find_if_not(table.columns.begin(), table.columns.end(), names) -
                                  table.columns.begin());
}

// Names of all rows, which differ.
std::vector<std::string> row_names(const Table& table) {
  for (std::size_t cells = 1; cells <= naming_columns(table); ++cells) {
    std::vector<std::string> names;
    for (const auto& row : table.rows) names.push_back(name_of_row(row, cells));
    const std::set<std::string> distinct(names.begin(), names.end());
    if (distinct.size() == names.size() && !distinct.contains("")) return names;
  }
  std::vector<std::string> names;
  for (std::size_t r = 0; r < table.rows.size(); ++r)
    names.push_back(macro_words("row " + std::to_string(r + 1)));
  return names;
}

bool is_end(const std::string& key, const std::string& word) {
  const std::string all = "_" + key + "_";
  return all.find("_" + word + "_") != std::string::npos;
}

class Numbers {
 public:
  void add(std::string name, const std::string& value) {
    const std::size_t before = seen_[name]++;
    if (before > 0)
      name +=
          before <= kAgain.size() ? kAgain[before - 1] : macro_words("copy " + std::to_string(before + 1));
    if (before > 0 && seen_[name]++ > 0) return add(name + "Again", value);
    all_.push_back({"trilat" + name, value});
  }
  std::vector<ArticleNumber> take() { return std::move(all_); }

 private:
  std::map<std::string, std::size_t> seen_;
  std::vector<ArticleNumber> all_;
};

std::string value_of(const TableValue& value) {
  return value.number && std::isfinite(*value.number) ? printed(value) : "--";
}

void add_row(Numbers& numbers, const Table& table, const std::vector<TableValue>& row,
             const std::string& name) {
  for (std::size_t c = 0; c < row.size(); ++c) {
    const std::string& key = table.columns[c].key;
    if (table.columns[c].is_text || !row[c].number) continue;
    numbers.add(name + macro_words(key), value_of(row[c]));
    const bool interval = c + 2 < row.size() && is_end(table.columns[c + 1].key, "from") &&
                          is_end(table.columns[c + 2].key, "to");
    if (!interval) continue;
    const std::string low = value_of(row[c + 1]), high = value_of(row[c + 2]);
    numbers.add(name + macro_words(key) + "Interval",
                low == "--" || high == "--" ? "--" : low + " to " + high);
  }
}

}  // namespace

std::string macro_words(const std::string& text) {
  std::string name;
  bool starts = true;
  for (char c : text) {
    if (c >= '0' && c <= '9') {
      name += kDigits[static_cast<std::size_t>(c - '0')];
      starts = true;
    } else if (is_command_letter(c)) {
      name += starts ? upper(c) : c;
      starts = false;
    } else {
      starts = true;
    }
  }
  return name;
}

std::vector<ArticleNumber> article_numbers(const std::vector<Table>& tables) {
  Numbers numbers;
  for (const Table& table : tables) {
    const std::vector<std::string> names = row_names(table);
    for (std::size_t r = 0; r < table.rows.size(); ++r)
      add_row(numbers, table, table.rows[r], macro_words(table.id) + names[r]);
  }
  return numbers.take();
}

std::string latex_of(const std::vector<ArticleNumber>& numbers) {
  std::string text =
      "% Every number of every table as a macro, so that prose never goes stale: \\input{numbers} before it "
      "is used.\n"
      "% \\trilat + table + row + column, digits written out; ...Interval is the 95 % interval of the number "
      "before it.\n"
      "% A macro is followed by {} where a space is to stay.\n";
  for (const ArticleNumber& number : numbers)
    text += "\\newcommand{\\" + number.name + "}{" + number.value + "}\n";
  return text;
}

}  // namespace trilat
