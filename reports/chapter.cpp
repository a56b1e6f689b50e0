// SPDX-License-Identifier: MIT
#include "reports/chapter.h"

#include <algorithm>
#include <functional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/results/paper_evidence.h"
#include "datasets/results/results_file.h"
#include "datasets/results/summary.h"
#include "datasets/results/table.h"
#include "reports/figures/figures.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

constexpr std::size_t kFirstFigures = 3;

void append(Chapter& chapter, std::vector<Table> more) {
  for (Table& table : more) chapter.tables.push_back(std::move(table));
}

void append(Chapter& chapter, std::vector<Figure> figures) {
  for (Figure& figure : figures) chapter.figures.push_back({std::move(figure), {}, {}});
}

Chapter new_chapter(const std::filesystem::path& path, const std::string& study,
                    const std::string& campaign = {}) {
  return {.provenance = read_provenance(path, study, campaign), .results = path, .title = study, .about = {}};
}

// With the paper its own tables answer; else methods by joint, and which take or side is odd.
Chapter accuracy_chapter(const std::filesystem::path& path, bool paper) {
  const ResultsSummary s = without_sets(read_summary(path));
  const std::optional<TrackingSummary> tracking = read_beside<TrackingSummary>(path);
  Chapter chapter = new_chapter(path, s.study, s.campaign);
  chapter.title = s.study + " on " + s.campaign;
  chapter.asked = "How far from the truth is each method?";
  chapter.simulated = s.simulated;
  chapter.about = fmt::format("{} of {} takes, {} participants, {}.", s.takes - s.takes_failed, s.takes,
                              s.participants, s.simulated ? "**simulated** sensors" : "recorded sensors");
  chapter.findings = accuracy_findings(s);
  chapter.warnings = accuracy_warnings(s);
  if (s.left_out()) chapter.sentences.push_back(truth_note(s));
  for (const CrossCheck& check : s.cross_checks)
    chapter.sentences.push_back(fmt::format(
        "Cross-check of `{}` with Ceres: {} samples, worst difference {:.3g} m (limit {:g} m): {}.",
        check.method, check.samples, check.worst_m, check.limit_m,
        check.passed() ? "agrees" : "**disagrees**"));
  // of the paper's studies one asks what compensation does
  const std::vector<Table> second = paper ? table2(s) : std::vector<Table>{};
  append(chapter, second);
  if (chapter.tables.empty()) append(chapter, article_tables(s, paper));
  if (!paper) append(chapter, oddity_tables(s));
  chapter.first_tables = chapter.tables.size();
  if (!second.empty()) append(chapter, article_tables(s, false));
  append(chapter, accuracy_tables(s));
  chapter.apart = apart_tables(s);
  if (tracking) append(chapter, tracking_tables(*tracking));
  for (const std::string& condition : s.conditions)
    append(chapter, std::vector{methods_figure(s, condition, paper && is_like_the_papers(s, condition))});
  append(chapter, sensor_counts_figure(s));
  append(chapter, trajectory_figures(path, s));
  chapter.first_figures = std::min<std::size_t>(chapter.figures.size(), kFirstFigures);
  chapter.replays = packed_replays(path, s);
  chapter.first_tables = std::min(chapter.first_tables, chapter.tables.size());
  return chapter;
}

// As the study stored it.
Chapter stored_chapter(const std::filesystem::path& path, const ResultsHead& head) {
  std::optional<StoredTables> stored = read_beside<StoredTables>(path);
  std::optional<StoredFigures> figures = read_beside<StoredFigures>(path);
  if (!stored || !figures)
    throw InputError(path.string(), fmt::format("holds no {}: an older program made it; run its study again",
                                                stored ? StoredFigures::kFile : StoredTables::kFile));
  Chapter chapter = new_chapter(path, head.study);
  chapter.simulated = head.simulated;
  chapter.asked = stored->asked;
  chapter.about = stored->about;
  chapter.findings = stored->findings;
  chapter.sentences = stored->findings;
  chapter.sentences.insert(chapter.sentences.end(), stored->sentences.begin(), stored->sentences.end());
  std::ranges::stable_sort(stored->tables, {}, &Table::shown);
  std::ranges::stable_sort(figures->figures, std::greater(), &Figure::is_first);
  for (Table& table : stored->tables) {
    chapter.first_tables += table.shown == Table::Shown::first;
    (table.shown == Table::Shown::file ? chapter.apart : chapter.tables).push_back(std::move(table));
  }
  chapter.first_figures =
      static_cast<std::size_t>(std::ranges::count(figures->figures, true, &Figure::is_first));
  append(chapter, std::move(figures->figures));
  return chapter;
}

}  // namespace

Chapter read_chapter(const std::filesystem::path& path, bool paper) {
  const ResultsHead head = read_results_head(path);
  return head.kind == StudyKind::accuracy ? accuracy_chapter(path, paper) : stored_chapter(path, head);
}

}  // namespace trilat
