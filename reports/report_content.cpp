// SPDX-License-Identifier: MIT
#include "reports/report_content.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/declared_parameters.h"
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

// What tells the results apart: the folder's name, and as many of the folders around it as that takes; a
// number where one folder was given twice.
std::vector<std::string> names_of(const std::vector<std::filesystem::path>& results) {
  const auto last_parts = [](const std::filesystem::path& folder, std::size_t count) {
    std::filesystem::path name, rest = whole_path(folder);
    for (; count > 0 && rest.has_relative_path(); --count, rest = rest.parent_path())
      name = name.empty() ? rest.filename() : rest.filename() / name;
    return name.generic_string();
  };
  std::vector<std::string> names;
  std::set<std::string> ids;
  for (const auto& folder : results) {
    const auto shared = [&](std::size_t parts) {
      return std::ranges::count_if(results, [&](const auto& other) {
               return whole_path(other) != whole_path(folder) &&
                      usable_id(last_parts(other, parts)) == usable_id(last_parts(folder, parts));
             }) > 0;
    };
    const std::filesystem::path whole = whole_path(folder);
    const auto depth = static_cast<std::size_t>(std::distance(whole.begin(), whole.end()));
    std::size_t parts = 1;
    while (parts < depth && shared(parts)) ++parts;
    const std::string name = last_parts(folder, parts);
    names.push_back(name);
    for (int n = 2; !ids.insert(usable_id(names.back())).second; ++n)
      names.back() = fmt::format("{} ({})", name, n);
  }
  return names;
}

std::vector<Table> parameter_tables(const std::vector<std::filesystem::path>& results,
                                    const std::vector<std::string>& names) {
  std::vector<std::pair<std::vector<DeclaredParameter>, std::string>> seen;
  for (std::size_t r = 0; r < results.size(); ++r) {
    const std::vector<DeclaredParameter> parameters = read_declared_parameters(results[r]);
    if (parameters.empty()) continue;
    const auto same =
        std::ranges::find_if(seen, [&](const auto& other) { return other.first == parameters; });
    if (same == seen.end())
      seen.emplace_back(parameters, names[r]);
    else
      same->second += ", " + names[r];
  }
  std::vector<Table> tables;
  for (const auto& [parameters, studies] : seen) {
    tables.push_back(parameters_table(parameters, studies));
    tables.back().id = usable_id(studies.substr(0, studies.find(',')));
  }
  return tables;
}

void draw_all(ReportContent& content) {
  std::vector<Figure> figures;
  for (Chapter& chapter : content.chapters)
    for (DrawnFigure& figure : chapter.figures) figures.push_back(std::move(figure.figure));
  std::vector<DrawnFigure> drawn = draw_figures(std::move(figures));
  const bool has_pictures = std::ranges::all_of(drawn, &DrawnFigure::is_drawn);
  auto next = drawn.begin();
  for (Chapter& chapter : content.chapters)
    for (DrawnFigure& figure : chapter.figures) figure = std::move(*next++);
  if (!has_pictures)
    content.headline.warnings.emplace_back(
        "There are no pictures, because gnuplot is not installed (`apt-get install gnuplot-nox`); the "
        "numbers of "
        "the figures are in CSV files.");
}

}  // namespace

ReportContent read_report(const std::vector<std::filesystem::path>& results,
                          const std::optional<PaperFindings>& paper,
                          const std::optional<ErrorChanges>& changes, const History& history,
                          const std::function<void(double)>& progress) {
  ReportContent content;
  const std::vector<std::string> names = names_of(results);
  for (const auto& path : results) {
    content.chapters.push_back(read_chapter(path, paper.has_value()));
    Chapter& chapter = content.chapters.back();
    const std::string name = names[content.chapters.size() - 1];
    if (name != chapter.provenance.folder) chapter.title += ": " + name;
    chapter.provenance.folder = name;
    if (progress)
      progress(static_cast<double>(content.chapters.size()) / static_cast<double>(results.size()));
  }
  std::set<std::string> ids, figure_ids;
  if (changes) {
    content.changes = changes_table(*changes);
    make_id(content.changes->id, "comparison", ids);
  }
  if (paper) {
    content.claims = claims_table(*paper);
    content.audit = {errata_table(*paper), audit_table()};
    make_id(content.claims->id, "paper", ids);
    for (Table& table : content.audit) make_id(table.id, "paper", ids);
  }
  for (Chapter& chapter : content.chapters) {
    const std::string study = usable_id(chapter.provenance.folder);
    for (Table& table : chapter.tables) make_id(table.id, study, ids);
    for (Table& table : chapter.apart) make_id(table.id, study, ids);
    for (DrawnFigure& figure : chapter.figures) make_id(figure.figure.id, study, figure_ids);
  }
  content.parameters = parameter_tables(results, names);
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

namespace {

// What is asked of is shown first, up to as many tables as a reader bears; `shown` or the others.
std::vector<const Table*> tables_that(const ReportContent& content, bool shown) {
  constexpr std::size_t kMostShown = 20;
  std::vector<const Table*> tables;
  std::size_t count = 0;
  const auto add = [&](const Table& table, bool asked) {
    const bool is_shown = asked && count < kMostShown;
    count += is_shown;
    if (is_shown == shown) tables.push_back(&table);
  };
  if (content.changes) add(*content.changes, true);
  if (content.claims) add(*content.claims, true);
  for (const Chapter& chapter : content.chapters)
    for (std::size_t t = 0; t < chapter.tables.size(); ++t) add(chapter.tables[t], t < chapter.first_tables);
  for (std::size_t t = 0; t < content.audit.size(); ++t) add(content.audit[t], t == 0);
  for (const Table& table : content.parameters) add(table, false);
  return tables;
}

}  // namespace

std::vector<const Table*> ReportContent::shown_tables() const { return tables_that(*this, true); }
std::vector<const Table*> ReportContent::other_tables() const { return tables_that(*this, false); }

}  // namespace trilat
