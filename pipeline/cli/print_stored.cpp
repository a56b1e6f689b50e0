// SPDX-License-Identifier: MIT
#include "pipeline/cli/print_stored.h"

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/results/results_file.h"
#include "datasets/results/table.h"
#include "reports/render/render.h"

namespace trilat {
namespace {

constexpr std::size_t kWidest = 100;

void print_sentence(std::string sentence) {
  std::erase_if(sentence, [](char c) { return c == '*' || c == '`'; });
  for (const std::string& line : lines_of(sentence, kWidest)) fmt::print("{}\n", line);
}

}  // namespace

void print_stored(const std::filesystem::path& results, bool all) {
  const std::optional<StoredTables> stored = read_json_file<StoredTables>(results);
  if (!stored) throw InputError(results.string(), "has no tables.json; run the study again");
  print_sentence(stored->title + ": " + stored->about);
  for (const Table& table : stored->tables) {
    const bool is_first = table.shown == Table::Placement::first;
    if (all && table.shown != Table::Placement::file) fmt::print("\n{}", markdown_of(table));
    if (!all && is_first && !table.rows.empty()) fmt::print("\n{}", terminal_text(table, kWidest));
  }
  fmt::print("\n");
  for (const std::string& sentence : stored->sentences) print_sentence(sentence);
  for (const std::string& finding : stored->findings) print_sentence(finding);
  for (const std::string& warning : stored->warnings) print_sentence("warning: " + warning);
}

}  // namespace trilat
