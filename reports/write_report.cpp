// SPDX-License-Identifier: MIT
#include "reports/write_report.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <optional>
#include <string>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "reports/embedded_citation.h"
#include "reports/page/page.h"
#include "reports/render/render.h"
#include "reports/report_content.h"

namespace trilat {
namespace {

// citation.bib: this program in its version, and the paper whose tables stand beside ours.
std::string citation_bibtex() {
  std::string text = embedded::citation_bib;
  const std::string program = kProgramVersion, mark = "VERSION";
  return text.replace(text.find(mark), mark.size(), program.substr(program.find(' ') + 1));
}

constexpr double kReadShare = 0.5, kPageShare = 0.2;  // of the whole; the rest is writing

// Brackets in the text would end the picture's name.
std::string markdown_of(const DrawnFigure& drawn) {
  const Figure& figure = drawn.figure;
  if (!drawn.is_drawn())
    return fmt::format("*{}. {}* [CSV](figures/{}.csv)\n", figure.title, figure.caption, figure.id);
  std::string name;
  for (char c : figure.title) name += c == '[' || c == ']' ? std::string("\\") + c : std::string(1, c);
  return fmt::format("![{}](figures/{}.svg)\n\n*{}. {}*\n", name, figure.id, figure.title, figure.caption);
}

// The page's text, tables and figures.
std::string markdown_of(const ReportContent& content) {
  const Headline& headline = content.headline;
  std::string markdown = fmt::format("# {}\n\n{}\n", headline.asked, headline.origin);
  for (const std::string& answer : headline.answers) markdown += "\n- " + answer;
  for (const std::string& warning : headline.warnings) markdown += "\n- Warning: " + warning;
  markdown += '\n';
  for (const std::string& line : headline.legend) markdown += "\n- " + line;
  if (!headline.legend.empty()) markdown += '\n';
  const auto add = [&](const Table& table) {
    if (table.shown == Table::Placement::first) markdown += "\n" + markdown_of(table);
  };
  if (content.changes) add(*content.changes);
  if (content.claims) add(*content.claims);
  for (const Chapter& chapter : content.chapters) {
    markdown += fmt::format("\n## {}\n\n{}\n", chapter.title, chapter.about);
    for (const std::string& sentence : chapter.sentences) markdown += "\n" + sentence + "\n";
    for (const Table& table : chapter.tables) add(table);
    for (const DrawnFigure& drawn : chapter.figures)
      if (drawn.figure.is_first) markdown += "\n" + markdown_of(drawn);
  }
  if (content.errata) add(*content.errata);
  return markdown;
}

std::string time_of_day() {
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

// Writes files aside, all of them before any is put in place: a run that is ended leaves the last report
// whole.
class Writer {
 public:
  Writer(const std::filesystem::path& folder, std::vector<std::filesystem::path>& written)
      : folder_(folder), aside_(partial_name(folder)), written_(written) {
    if (aside_.has_parent_path()) make_folder(aside_.parent_path());
    lock_.emplace(aside_);
    std::error_code ignored;
    std::filesystem::remove_all(aside_, ignored);
    make_folder(aside_);
  }
  ~Writer() {
    std::error_code ignored;
    std::filesystem::remove_all(aside_, ignored);
  }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  void operator()(const std::string& name, const std::string& text) {
    make_folder((aside_ / name).parent_path());
    write_file(aside_ / name, text);
    written_.push_back(folder_ / name);
  }

  // Files and folders of an earlier report are exchanged; what else is there stays.
  void put_in_place() const {
    make_folder(folder_);
    const auto move = [&](bool folders) {
      for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(aside_)) {
        if (entry.is_directory() != folders) continue;
        const std::filesystem::path to = folder_ / entry.path().filename();
        if (folders) std::filesystem::remove_all(to);
        std::filesystem::rename(entry.path(), to);
      }
    };
    move(false);
    move(true);
  }

 private:
  std::filesystem::path folder_, aside_;
  std::optional<FolderLock> lock_;
  std::vector<std::filesystem::path>& written_;
};

// Writes each table as CSV, and as LaTeX too where it fits an article's page. The study itself may have
// written the rows of a long table.
void write_tables(const ReportContent& content, Writer& write, const std::function<void(double)>& advance) {
  const std::vector<const Table*> tables = content.tables();
  for (std::size_t t = 0; t < tables.size(); ++t) {
    const Table& table = *tables[t];
    write("tables/" + table.id + ".csv", table.rows_in.empty() ? csv_of(table) : read_file(table.rows_in));
    if (table.shown != Table::Placement::file)
      if (const auto latex = latex_of(table)) write("tables/" + table.id + ".tex", *latex);
    advance(static_cast<double>(t + 1) / static_cast<double>(tables.size()));
  }
}

void write_figures(const ReportContent& content, Writer& write) {
  std::vector<const DrawnFigure*> figures;
  if (content.headline.history) figures.push_back(&*content.headline.history);
  for (const Chapter& chapter : content.chapters)
    for (const DrawnFigure& figure : chapter.figures) figures.push_back(&figure);
  for (const DrawnFigure* figure : figures) {
    const std::string path = "figures/" + figure->figure.id;
    if (figure->is_drawn()) {
      write(path + ".svg", figure->svg);
      write(path + ".pdf", figure->pdf);
    }
    write(path + ".csv", csv_of(figure->figure));
  }
}

}  // namespace

ReportFiles write_report(const std::vector<std::filesystem::path>& results,
                         const std::filesystem::path& folder, const ReportOptions& options) {
  const auto advance = [&](double share) {
    if (options.progress) options.progress(share);
  };
  const ReportContent content = read_report(results, options.paper, options.changes, options.history,
                                            [&](double share) { advance(kReadShare * share); });
  ReportFiles report{content.headline, content.tables().size(), content.headline.history.has_value(), {}};
  for (const Chapter& chapter : content.chapters) report.figures += chapter.figures.size();
  const PageOptions page{options.made.empty() ? time_of_day() : options.made, citation_bibtex(),
                         std::filesystem::exists(options.three_js) ? read_file(options.three_js) : ""};
  Writer write(folder, report.written);
  write("report.html", page_of(content, page));
  advance(kReadShare + kPageShare);
  write("report.md", markdown_of(content));
  write("citation.bib", citation_bibtex());
  for (const Chapter& chapter : content.chapters)
    if (!chapter.provenance.config.empty())
      write(study_file(chapter.provenance), chapter.provenance.config + "\n");
  write_tables(content, write, [&](double share) {
    advance(kReadShare + kPageShare + (1.0 - kReadShare - kPageShare) * share);
  });
  write_figures(content, write);
  write.put_in_place();
  return report;
}

}  // namespace trilat
