// SPDX-License-Identifier: MIT
#include "reports/chapter.h"

#include <algorithm>
#include <functional>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/results/paper_evidence.h"
#include "datasets/results/results_file.h"
#include "datasets/results/summary.h"
#include "reports/claims/add_printed.h"
#include "reports/figures/figures.h"

namespace trilat {
namespace {

constexpr std::size_t kFirstFigures = 3;

void append(Chapter& chapter, std::vector<Figure> figures) {
  for (Figure& figure : figures) chapter.figures.push_back({std::move(figure), {}, {}});
}

// Beside the paper its own tables answer.
void put_the_paper_first(std::vector<Table>& tables) {
  for (Table& table : tables) add_printed(table);
  if (std::ranges::all_of(tables, [](const Table& table) { return table.printed.empty(); })) return;
  const bool second = std::ranges::any_of(tables, [](const Table& t) { return t.printed == "table2"; });
  for (Table& table : tables)
    if (table.shown != Table::Shown::file)
      table.shown =
          table.printed == (second ? "table2" : "table3") ? Table::Shown::first : Table::Shown::detail;
}

// What needs the samples.
void add_takes(Chapter& chapter) {
  const ResultsSummary summary = read_summary(chapter.results);
  append(chapter, trajectory_figures(chapter.results, summary));
  chapter.first_figures = std::min(kFirstFigures, std::max(chapter.first_figures, chapter.figures.size()));
  chapter.replays = packed_replays(chapter.results, summary);
}

}  // namespace

Chapter read_chapter(const std::filesystem::path& path, bool paper) {
  const ResultsHead head = read_results_head(path);
  std::optional<StoredTables> stored = read_beside<StoredTables>(path);
  std::optional<StoredFigures> figures = read_beside<StoredFigures>(path);
  if (!stored || !figures)
    throw InputError(path.string(), fmt::format("holds no {}: an older program made it; run its study again",
                                                stored ? StoredFigures::kFile : StoredTables::kFile));
  Chapter chapter{.provenance = read_provenance(path, head.study, head.campaign),
                  .results = path,
                  .asked = stored->asked,
                  .title = stored->title,
                  .about = stored->about,
                  .simulated = head.simulated,
                  .findings = stored->findings,
                  .on_the_paper = stored->on_the_paper,
                  .warnings = stored->warnings};
  // a study with a campaign has its findings on the first screen alone
  if (head.campaign.empty()) chapter.sentences = stored->findings;
  chapter.sentences.insert(chapter.sentences.end(), stored->sentences.begin(), stored->sentences.end());
  if (paper) {
    put_the_paper_first(stored->tables);
    for (Figure& figure : figures->figures) add_printed(figure);
  }
  std::ranges::stable_sort(stored->tables, {}, &Table::shown);
  std::ranges::stable_sort(figures->figures, std::greater(), &Figure::is_first);
  for (Table& table : stored->tables) {
    chapter.first_tables += table.shown == Table::Shown::first;
    (table.shown == Table::Shown::file ? chapter.apart : chapter.tables).push_back(std::move(table));
  }
  chapter.first_figures =
      static_cast<std::size_t>(std::ranges::count(figures->figures, true, &Figure::is_first));
  append(chapter, std::move(figures->figures));
  if (head.kind == StudyKind::accuracy) add_takes(chapter);
  return chapter;
}

}  // namespace trilat
