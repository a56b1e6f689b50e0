// SPDX-License-Identifier: MIT
#include "reports/report_content.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/declared_parameters.h"
#include "reports/claims/claims.h"
#include "reports/provenance.h"

namespace trilat {
namespace {

// Ids become file names, so two results of one kind must not share them.
void make_unique(std::string& id, std::set<std::string>& ids, const std::string& study) {
  if (ids.insert(id).second) return;
  const std::string base = usable_id(study + "-" + id);
  id = base;
  for (int n = 2; !ids.insert(id).second; ++n) id = fmt::format("{}-{}", base, n);
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
      return std::count_if(results.begin(), results.end(), [&](const auto& other) {
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
        std::find_if(seen.begin(), seen.end(), [&](const auto& other) { return other.first == parameters; });
    if (same == seen.end())
      seen.emplace_back(parameters, names[r]);
    else
      same->second += ", " + names[r];
  }
  std::vector<Table> tables;
  for (const auto& [parameters, studies] : seen) tables.push_back(parameters_table(parameters, studies));
  return tables;
}

void draw_all(ReportContent& content) {
  std::vector<DrawnFigure> drawn = draw_figures(figures_of(content));
  auto next = drawn.begin();
  for (Chapter& chapter : content.chapters)
    for (DrawnFigure& figure : chapter.figures) figure = std::move(*next++);
}

void refuse_unfinished(const std::filesystem::path& given) {
  const std::filesystem::path folder = given.has_filename() ? given : given.parent_path();
  const bool is_partial = folder.extension() == ".partial";
  const std::filesystem::path partial = is_partial ? folder : partial_name(folder);
  if (is_partial || (!std::filesystem::exists(folder) && std::filesystem::exists(partial)))
    throw InputError(partial.string(), "is what an unfinished run left. Run it again, or remove it");
}

}  // namespace

ReportContent read_report(const std::vector<std::filesystem::path>& results,
                          const std::optional<PaperFindings>& paper,
                          const std::function<void(double)>& progress) {
  ReportContent content;
  const std::vector<std::string> names = names_of(results);
  for (const auto& path : results) {
    refuse_unfinished(path);
    content.chapters.push_back(read_chapter(path));
    Chapter& chapter = content.chapters.back();
    const std::string name = names[content.chapters.size() - 1];
    if (name != chapter.provenance.folder) chapter.title += ": " + name;
    chapter.provenance.folder = name;
    if (progress)
      progress(static_cast<double>(content.chapters.size()) / static_cast<double>(results.size()));
  }
  std::set<std::string> ids;
  if (paper) {
    content.claims = claims_table(*paper);
    content.audit = {audit_table(), errata_table(*paper)};
    for (const Table& table : content.audit) ids.insert(table.id);
    ids.insert(content.claims->id);
  }
  for (Chapter& chapter : content.chapters) {
    const std::string& study = chapter.provenance.study;
    for (Table& table : chapter.tables) make_unique(table.id, ids, study);
    for (Table& table : chapter.apart) make_unique(table.id, ids, study);
    for (DrawnFigure& figure : chapter.figures) make_unique(figure.figure.id, ids, study);
  }
  content.parameters = parameter_tables(results, names);
  for (Table& table : content.parameters) make_unique(table.id, ids, "report");
  draw_all(content);
  return content;
}

std::vector<Table> tables_of(const ReportContent& content) {
  std::vector<Table> tables;
  if (content.claims) tables.push_back(*content.claims);
  tables.insert(tables.end(), content.audit.begin(), content.audit.end());
  for (const Chapter& chapter : content.chapters)
    tables.insert(tables.end(), chapter.tables.begin(), chapter.tables.end());
  tables.insert(tables.end(), content.parameters.begin(), content.parameters.end());
  return tables;
}

std::vector<Table> main_tables_of(const ReportContent& content) {
  std::vector<Table> tables;
  if (content.claims) tables.push_back(*content.claims);
  for (const Chapter& chapter : content.chapters)
    tables.insert(tables.end(), chapter.tables.begin(),
                  chapter.tables.begin() + static_cast<std::ptrdiff_t>(chapter.first_tables));
  return tables;
}

std::vector<Figure> figures_of(const ReportContent& content) {
  std::vector<Figure> figures;
  for (const Chapter& chapter : content.chapters)
    for (const DrawnFigure& figure : chapter.figures) figures.push_back(figure.figure);
  return figures;
}

}  // namespace trilat
