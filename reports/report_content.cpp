// SPDX-License-Identifier: MIT
#include "reports/report_content.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/simulation_assumptions.h"
#include "reports/claims/claims.h"
#include "reports/figures/figures.h"
#include "reports/provenance.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

// "table3/errors-walking": a path within the report's folders of tables and figures, and a name in the page.
// Two names that differ in letters that no file name has would become one.
void make_id(std::string& id, const std::string& study, std::set<std::string>& ids) {
  id = study + "/" + id;
  while (!ids.insert(id).second) id += '_';
}

// A report names what it shows by the folders of the results.
void check_names(const std::vector<std::filesystem::path>& results) {
  std::map<std::string, std::filesystem::path> known;
  for (const std::filesystem::path& folder : results)
    if (const auto [found, is_new] = known.emplace(file_name_from(folder_name(folder)), folder); !is_new)
      throw InputError(folder.string(), fmt::format("has the name of {}, and a report names its tables by "
                                                    "it: rename one of the two, or write two reports",
                                                    found->second.string()));
}

std::vector<Table> parameter_tables(const std::vector<std::filesystem::path>& results) {
  std::vector<std::pair<std::vector<SimulationAssumption>, std::string>> seen;
  for (const std::filesystem::path& folder : results) {
    const std::vector<SimulationAssumption> parameters = read_simulation_assumptions(folder);
    if (parameters.empty()) continue;
    const auto same =
        std::ranges::find_if(seen, [&](const auto& other) { return other.first == parameters; });
    if (same == seen.end())
      seen.emplace_back(parameters, folder_name(folder));
    else
      same->second += ", " + folder_name(folder);
  }
  std::vector<Table> tables;
  for (const auto& [parameters, studies] : seen) {
    tables.push_back(parameters_table(parameters, studies));
    tables.back().id = file_name_from(studies.substr(0, studies.find(',')));
  }
  return tables;
}

// Keeps the first twenty tables on the page; the others stay as files.
void limit_shown(ReportContent& content) {
  std::size_t left = 20 - content.changes.has_value() - 2 * content.claims.has_value();
  for (Chapter& chapter : content.chapters)
    for (Table& table : chapter.tables) {
      if (table.shown != Table::Placement::first) continue;
      if (left == 0)
        table.shown = Table::Placement::detail;
      else
        --left;
    }
}

void draw_all(ReportContent& content) {
  std::vector<Figure> figures;
  std::vector<Figure> narrow;
  for (Chapter& chapter : content.chapters)
    for (DrawnFigure& drawn : chapter.figures) {
      if (drawn.in_headline && !drawn.figure.y_names.empty()) narrow.push_back(narrow_figure(drawn.figure));
      figures.push_back(std::move(drawn.figure));
    }
  std::ranges::move(narrow, std::back_inserter(figures));
  std::vector<DrawnFigure> drawn = draw_figures(std::move(figures));
  const bool has_pictures = std::ranges::all_of(drawn, &DrawnFigure::is_drawn);
  auto next = drawn.begin();
  for (Chapter& chapter : content.chapters)
    for (DrawnFigure& figure : chapter.figures) {
      next->in_headline = figure.in_headline;
      figure = std::move(*next++);
    }
  for (Chapter& chapter : content.chapters)
    for (DrawnFigure& figure : chapter.figures)
      if (figure.in_headline && !figure.figure.y_names.empty()) figure.narrow_svg = std::move((next++)->svg);
  if (!has_pictures)
    content.headline.warnings.emplace_back(
        "There are no pictures, because gnuplot is not installed (`apt-get install gnuplot-nox`); the "
        "numbers of the figures are in CSV files.");
}

}  // namespace

ReportContent read_report(const std::vector<std::filesystem::path>& results,
                          const std::optional<PaperFindings>& paper,
                          const std::optional<ErrorChanges>& changes, const std::vector<Night>& history,
                          const std::function<void(double)>& progress) {
  check_names(results);
  ReportContent content;
  for (const auto& path : results) {
    content.chapters.push_back(read_chapter(path, paper.has_value()));
    if (progress)
      progress(static_cast<double>(content.chapters.size()) / static_cast<double>(results.size()));
  }
  std::set<std::string> ids, figure_ids;
  if (changes) {
    content.changes = changes_table(*changes);
    make_id(content.changes->id, "comparison", ids);
    content.changes->shown = Table::Placement::first;
  }
  if (paper) {
    content.claims = claims_table(*paper);
    content.errata = errata_table(*paper);
    for (Table* table : {&*content.claims, &*content.errata}) {
      make_id(table->id, "paper", ids);
      table->shown = Table::Placement::first;
    }
  }
  for (Chapter& chapter : content.chapters) {
    const std::string study = file_name_from(chapter.provenance.folder);
    for (Table& table : chapter.tables) make_id(table.id, study, ids);
    for (DrawnFigure& figure : chapter.figures) make_id(figure.figure.id, study, figure_ids);
  }
  limit_shown(content);
  content.parameters = parameter_tables(results);
  if (!content.parameters.empty()) content.parameters.push_back(recorded_table());
  for (Table& table : content.parameters) make_id(table.id, "assumptions", ids);
  content.headline = headline_of(content, paper, changes);
  const std::vector<std::string> night = history_sentences(history);
  content.headline.answers.insert(content.headline.answers.begin(), night.begin(), night.end());
  if (std::optional<Figure> figure = history_figure(history)) {
    make_id(figure->id, "nights", figure_ids);
    content.headline.history = draw_figures({std::move(*figure)}).front();
  }
  draw_all(content);
  return content;
}

std::vector<const Table*> ReportContent::tables() const {
  std::vector<const Table*> all;
  if (changes) all.push_back(&*changes);
  if (claims) all.push_back(&*claims);
  for (const Chapter& chapter : chapters)
    for (const Table& table : chapter.tables) all.push_back(&table);
  if (errata) all.push_back(&*errata);
  for (const Table& table : parameters) all.push_back(&table);
  return all;
}

}  // namespace trilat
