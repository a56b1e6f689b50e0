// SPDX-License-Identifier: MIT
#include "reports/report_content.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/words.h"
#include "datasets/results/paper_evidence.h"
#include "datasets/results/results_file.h"
#include "datasets/results/simulation_assumptions.h"
#include "datasets/results/summary.h"
#include "reports/figures/figures.h"
#include "reports/provenance.h"
#include "reports/render/render.h"
#include "reports/tables.h"

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

namespace {

constexpr std::size_t kMaxAnswers = 4;
// "Recorded, for comparison: WHAT: 0.8 to 4.4 cm; …".
std::string recorded_sentence(const Table& recorded) {
  std::string text;
  for (const std::vector<TableValue>& row : recorded.rows)
    text += fmt::format("{}{}: {} to {} cm", text.empty() ? "Recorded, for comparison: " : "; ", row[0].text,
                        printed(row[1]), printed(row[2]));
  return text + ".";
}

void add_verdicts(const std::vector<JudgedClaim>& claims, Headline& headline) {
  for (std::size_t v = 0; v < kVerdictNames.size(); ++v)
    if (const auto n = std::ranges::count(claims, static_cast<ClaimVerdict>(v), &JudgedClaim::verdict))
      headline.verdicts.emplace_back(static_cast<ClaimVerdict>(v), static_cast<std::size_t>(n));
}

// The first figure that is wanted of those that answer a question, with what its methods are.
void put_in_headline(ReportContent& content, Headline& headline, const auto& is_wanted) {
  for (Chapter& chapter : content.chapters)
    for (DrawnFigure& drawn : chapter.figures)
      if (drawn.figure.is_first && is_wanted(chapter, drawn.figure)) {
        drawn.in_headline = true;
        headline.legend = chapter.legend;
        return;
      }
}

// The warnings of all studies. A warning that several give is printed once, behind their names.
std::vector<std::string> warnings_of(const std::vector<Chapter>& chapters) {
  std::vector<std::pair<std::string, std::string>> said;  // by whom, and what
  for (const Chapter& chapter : chapters)
    for (const std::string& warning : chapter.warnings) {
      const auto same = std::ranges::find(said, warning, &std::pair<std::string, std::string>::second);
      if (same == said.end())
        said.emplace_back(chapter.provenance.folder, warning);
      else
        same->first += ", " + chapter.provenance.folder;
    }
  std::vector<std::string> warnings;
  for (const auto& [by, warning] : said)
    warnings.push_back(chapters.size() > 1 ? by + ": " + warning : warning);
  return warnings;
}

}  // namespace

Headline headline_of(ReportContent& content, const std::optional<PaperFindings>& paper,
                     const std::optional<ErrorChanges>& changes) {
  Headline headline;
  bool simulated = false, recorded = false;
  for (const Chapter& chapter : content.chapters) (chapter.simulated ? simulated : recorded) = true;
  headline.origin = simulated && recorded ? "Simulated and recorded data"
                    : simulated           ? "Simulated data"
                                          : "Recorded data";
  // the experiment that the paper's question is asked of
  const auto is_walking = [](const Chapter& c) { return c.paper == name_of(PaperStudy::table3); };
  const bool on_the_paper = paper && std::ranges::any_of(content.chapters, [&](const Chapter& c) {
                              return is_walking(c) && !c.on_the_paper.empty();
                            });
  headline.warnings = warnings_of(content.chapters);
  if (paper) add_verdicts(paper->claims, headline);
  if (on_the_paper) {
    headline.asked =
        "Does nonlinear trilateration of several Kinect v2 find joints better than the plain mean of them?";
    for (const Chapter& chapter : content.chapters)
      if (is_walking(chapter))
        headline.answers.insert(headline.answers.end(), chapter.on_the_paper.begin(),
                                chapter.on_the_paper.end());
    if (simulated) headline.answers.back() += " " + recorded_sentence(recorded_table());
    put_in_headline(content, headline,
                    [&](const Chapter& c, const Figure& f) { return is_walking(c) && !f.y_names.empty(); });
    return headline;
  }
  if (changes) {
    headline.asked = "What changed, by how much, and is it real?";
    headline.answers = changes_sentences(*changes);
    put_in_headline(content, headline, [](const Chapter&, const Figure&) { return true; });
    return headline;
  }
  const bool one_question = std::ranges::all_of(
      content.chapters, [&](const Chapter& c) { return c.asked == content.chapters.front().asked; });
  headline.asked = one_question ? content.chapters.front().asked : "What did the studies find?";
  std::size_t left_out = 0;
  for (const Chapter& chapter : content.chapters)
    for (const std::string& finding : chapter.findings.empty() ? chapter.sentences : chapter.findings) {
      if (headline.answers.size() < kMaxAnswers)
        headline.answers.push_back(content.chapters.size() > 1 ? chapter.provenance.folder + ": " + finding
                                                               : finding);
      else
        ++left_out;
    }
  if (left_out > 0) headline.answers.push_back(fmt::format("And {} more, in the studies below.", left_out));
  put_in_headline(content, headline, [](const Chapter&, const Figure&) { return true; });
  return headline;
}

std::string warnings_text(const Headline& headline) {
  const std::size_t count = headline.warnings.size();
  return counted(count, "warning") + (count == 1 ? "" : ", the first");
}

std::string headline_text(const Headline& headline) {
  constexpr std::size_t kColumns = 96;
  std::string text = headline.asked + " " + headline.origin + ".\n";
  const auto add = [&](std::string sentence) {
    std::erase_if(sentence, [](char c) { return c == '*' || c == '`'; });
    bool first = true;
    for (const std::string& line : lines_of(sentence, kColumns)) {
      text += (first ? "  - " : "    ") + line + "\n";
      first = false;
    }
  };
  for (const std::string& answer : headline.answers) add(answer);
  std::string verdicts;
  for (const auto& [verdict, count] : headline.verdicts)
    verdicts += fmt::format("{}{} {}", verdicts.empty() ? "" : ", ", name_of(verdict), count);
  if (!verdicts.empty()) add("The paper's claims: " + verdicts + ".");
  if (!headline.warnings.empty())
    add(fmt::format("{}: {}", warnings_text(headline), headline.warnings.front()));
  return text;
}

}  // namespace trilat
