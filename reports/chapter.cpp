// SPDX-License-Identifier: MIT
#include "reports/chapter.h"

#include <algorithm>
#include <functional>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/results/paper_evidence.h"
#include "datasets/results/results_file.h"
#include "datasets/results/summary.h"
#include "reports/claims/claims.h"
#include "reports/figures/figures.h"

namespace trilat {
namespace {

constexpr std::ptrdiff_t kFirstFigures = 3;

// Beside the paper its own tables answer.
void put_the_paper_first(std::vector<Table>& tables, bool simulated) {
  for (Table& table : tables) add_printed(table, simulated);
  for (const char* answers : {"table2", "table3"}) {
    if (std::ranges::find(tables, answers, &Table::printed) == tables.end()) continue;
    for (Table& table : tables)
      if (table.shown != Table::Placement::file)
        table.shown = table.printed == answers ? Table::Placement::first : Table::Placement::detail;
    return;
  }
}

// Adds the trajectory figures and the replays, which are drawn from the samples of single takes.
void add_takes(Chapter& chapter) {
  const ResultsSummary summary = read_results<ResultsSummary>(chapter.results);
  auto first =
      std::ranges::count_if(chapter.figures, [](const DrawnFigure& drawn) { return drawn.figure.is_first; });
  for (Figure& figure : trajectory_figures(chapter.results, summary)) {
    figure.is_first = first++ < kFirstFigures;
    chapter.figures.push_back({std::move(figure), {}, {}});
  }
  chapter.replays = packed_replays(chapter.results, summary);
}

}  // namespace

Chapter read_chapter(const std::filesystem::path& path, bool paper) {
  const ResultsHead head = read_results_head(path);
  std::optional<StoredTables> stored = read_json_file<StoredTables>(path);
  std::optional<StoredFigures> figures = read_json_file<StoredFigures>(path);
  if (!stored || !figures)
    throw InputError(path.string(), fmt::format("holds no {}: an older program made it; run its study again",
                                                stored ? StoredFigures::kFile : StoredTables::kFile));
  Chapter chapter{.provenance = read_provenance(path, head.kind, head.study, head.campaign),
                  .results = path,
                  .paper = head.paper,
                  .asked = stored->asked,
                  .title = stored->title,
                  .about = stored->about,
                  .simulated = head.simulated,
                  .findings = stored->findings,
                  .on_the_paper = stored->on_the_paper,
                  .warnings = stored->warnings,
                  .legend = stored->legend};
  // a study with a campaign has its findings on the first screen alone
  if (head.campaign.empty()) chapter.sentences = stored->findings;
  chapter.sentences.insert(chapter.sentences.end(), stored->sentences.begin(), stored->sentences.end());
  if (paper) {
    put_the_paper_first(stored->tables, head.simulated);
    for (Figure& figure : figures->figures) add_printed(figure);
  }
  std::ranges::stable_sort(stored->tables, {}, &Table::shown);
  std::ranges::stable_sort(figures->figures, std::greater(), &Figure::is_first);
  chapter.tables = std::move(stored->tables);
  for (Table& table : chapter.tables)
    if (!table.rows_in.empty()) table.rows_in = (path / table.rows_in).string();
  for (Figure& figure : figures->figures) chapter.figures.push_back({std::move(figure), {}, {}});
  if (head.kind == StudyKind::accuracy) add_takes(chapter);
  return chapter;
}

}  // namespace trilat
