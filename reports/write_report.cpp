// SPDX-License-Identifier: MIT
#include "reports/write_report.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <optional>
#include <sstream>
#include <string>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "datasets/base/files.h"
#include "datasets/base/folder_lock.h"
#include "datasets/base/version.h"
#include "reports/page/page.h"
#include "reports/render/latex.h"
#include "reports/render/render.h"
#include "reports/report_content.h"

namespace trilat {
namespace {

// citation.bib: this program in its version, and the paper whose tables stand beside ours.
std::string citation_bibtex() {
  const std::string program = kProgramVersion;
  const auto space = program.find(' ');
  return "% What this report was made with. Name the version, and the study's SHA-256 from the page's "
         "provenance.\n"
         "@software{trilat,\n"
         "  title   = {" +
         program.substr(0, space) +
         ": offline evaluation of trilateration with several Kinect v2 sensors},\n"
         "  version = {" +
         program.substr(space + 1) +
         "}\n"
         "}\n"
         "% The paper whose claims and tables are held against the results.\n"
         "@misc{yang2022selfcalibrated,\n"
         "  title  = {Development of a Self-Calibrated Motion Capture System by Nonlinear Trilateration of "
         "Multiple "
         "Kinects v2},\n"
         "  author = {Yang, Bowen and Dong, Haiwei and El Saddik, Abdulmotaleb},\n"
         "  year   = {2022},\n"
         "  eprint = {2212.14771},\n"
         "  archivePrefix = {arXiv}\n"
         "}\n";
}

constexpr double kReadShare = 0.5, kPageShare = 0.2;  // of the whole; the rest is writing

// Brackets in the text would end the picture's name.
std::string markdown_of(const Figure& figure) {
  std::string name;
  for (char c : figure.title) name += c == '[' || c == ']' ? std::string("\\") + c : std::string(1, c);
  return fmt::format("![{}]({}.svg)\n\n*{}*\n", name, figure.id, figure.caption);
}

std::string markdown_of(const ReportContent& content) {
  std::string markdown = "# Trilateration accuracy\n";
  if (content.claims) markdown += "\n" + markdown_of(*content.claims);
  for (const Table& table : content.audit) markdown += "\n" + markdown_of(table);
  for (const Chapter& chapter : content.chapters) {
    markdown += fmt::format("\n## {}\n\n{}\n", chapter.title, chapter.about);
    for (const std::string& sentence : chapter.sentences) markdown += "\n" + sentence + "\n";
    for (const Table& table : chapter.tables) markdown += "\n" + markdown_of(table);
    for (const DrawnFigure& figure : chapter.figures) markdown += "\n" + markdown_of(figure.figure);
  }
  for (const Table& table : content.parameters) markdown += "\n" + markdown_of(table);
  return markdown;
}

std::string time_of_day() {
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

constexpr const char* kList = "files.txt";  // what a report wrote, for the next one to remove

// Writes files aside, all of them before any is put in place: a run that is ended leaves the last report
// whole.
class Writer {
 public:
  Writer(const std::filesystem::path& folder, ReportFiles& report)
      : folder_(folder), aside_(partial_name(folder)), report_(report) {
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
    names_.push_back(name);
  }

  void put_in_place() {
    (*this)(kList, fmt::format("{}\n", fmt::join(names_, "\n")));
    std::rotate(names_.rbegin(), names_.rbegin() + 1, names_.rend());  // by the list a report is known
    make_folder(folder_);
    remove_left_over();
    for (const std::string& name : names_) {
      make_folder((folder_ / name).parent_path());
      std::filesystem::rename(aside_ / name, folder_ / name);
      if (name != kList) report_.written.push_back(folder_ / name);
    }
  }

 private:
  // What the last report here wrote and this one does not; nothing that a report did not write.
  void remove_left_over() const {
    if (!std::filesystem::exists(folder_ / kList)) return;
    std::istringstream list(read_file(folder_ / kList));
    for (std::string name; std::getline(list, name);) {
      const std::filesystem::path path(name);
      const bool inside = !name.empty() && path.is_relative() && name.find("..") == std::string::npos;
      if (!inside || std::find(names_.begin(), names_.end(), name) != names_.end()) continue;
      std::error_code ignored;
      std::filesystem::remove(folder_ / path, ignored);
    }
  }

  std::filesystem::path folder_, aside_;
  std::optional<FolderLock> lock_;
  ReportFiles& report_;
  std::vector<std::string> names_;
};

void write_studies(const ReportContent& content, Writer& write) {
  for (const Chapter& chapter : content.chapters)
    if (!chapter.provenance.config.empty())
      write(study_file(chapter.provenance), chapter.provenance.config + "\n");
}

}  // namespace

ReportFiles write_report(const std::vector<std::filesystem::path>& results,
                         const std::filesystem::path& folder, const ReportOptions& options) {
  const auto advance = [&](double share) {
    if (options.progress) options.progress(share);
  };
  const ReportContent content =
      read_report(results, options.paper, [&](double share) { advance(kReadShare * share); });
  ReportFiles report{tables_of(content), figures_of(content), {}};
  const std::string page =
      page_of(content, {options.made.empty() ? time_of_day() : options.made, citation_bibtex(),
                        std::filesystem::exists(options.three_js) ? read_file(options.three_js) : ""});
  advance(kReadShare + kPageShare);
  Writer write(folder, report);
  write("report.html", page);
  write("report.md", markdown_of(content));
  write("numbers.tex", latex_of(article_numbers(main_tables_of(content))));
  write("citation.bib", citation_bibtex());
  write_studies(content, write);
  for (std::size_t t = 0; t < report.tables.size(); ++t) {
    const Table& table = report.tables[t];
    write(table.id + ".csv", csv_of(table));
    write(table.id + ".tex", latex_of(table));
    advance(kReadShare + kPageShare +
            (1.0 - kReadShare - kPageShare) * static_cast<double>(t + 1) /
                static_cast<double>(report.tables.size()));
  }
  for (const Chapter& chapter : content.chapters)
    for (const Table& table : chapter.apart) write(table.id + ".csv", csv_of(table));
  for (const Chapter& chapter : content.chapters)
    for (const DrawnFigure& figure : chapter.figures) {
      write(figure.figure.id + ".svg", figure.svg);
      write(figure.figure.id + ".pdf", figure.pdf);
      write(figure.figure.id + ".csv", csv_of(figure.figure));
    }
  write.put_in_place();
  return report;
}

}  // namespace trilat
