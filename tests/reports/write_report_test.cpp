// SPDX-License-Identifier: MIT
#include "reports/write_report.h"

#include <algorithm>
#include <cstdlib>
#include <set>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "tests/reports/calibration_summaries.h"
#include "tests/reports/summaries.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

constexpr const char* kPdflatex = "/usr/bin/pdflatex";

std::filesystem::path results_in(const ScratchFolder& folder, const std::string& name,
                                 const ResultsSummary& summary) {
  std::filesystem::create_directories(folder / name);
  write_summary(folder / name, summary);
  return folder / name;
}

std::filesystem::path results_in(const ScratchFolder& folder, const std::string& name,
                                 const CalibrationSummary& summary) {
  std::filesystem::create_directories(folder / name);
  write_results(folder / name, summary);
  return folder / name;
}

// Every text that comes from outside, with everything LaTeX and Markdown care about.
ResultsSummary nasty_summary() {
  ResultsSummary summary = hand_made_summary();
  const std::string nasty = "50 % & $1 #2 a_b {c} ~d ^e \\f |g| <h> \"i\"\n\nj é";
  summary.campaign = nasty;
  summary.conditions = {nasty};
  summary.methods = {nasty};
  for (SummaryCell& cell : summary.cells) {
    cell.condition = nasty;
    cell.method = nasty;
    cell.group = nasty;
  }
  summary.notes = {{nasty, true, nasty, nasty}};
  return summary;
}

bool compiles(const std::filesystem::path& document) {
  const std::string command = "cd '" + document.parent_path().string() + "' && " + kPdflatex +
                              " -interaction=nonstopmode -halt-on-error '" + document.filename().string() +
                              "' > pdflatex.txt 2>&1";
  return std::system(command.c_str()) == 0;
}

TEST(Report, HoldsEveryTableInEveryForm) {
  const ScratchFolder folder;
  const ReportFiles report = write_report({results_in(folder, "results", hand_made_summary())},
                                          folder / "report", {.paper = PaperFindings{}});
  ASSERT_EQ(report.tables, 5u);
  const ReportContent content = read_report({folder / "results"}, PaperFindings{});
  const std::string markdown = read_file(folder / "report/report.md"),
                    page = read_file(folder / "report/report.html");
  for (const Table* table : content.shown_tables()) EXPECT_THAT(markdown, HasSubstr(table->title));
  for (const auto& tables : {content.shown_tables(), content.other_tables()})
    for (const Table* table : tables) {
      EXPECT_THAT(page, HasSubstr("href=\"tables/" + table->id + ".csv\""));
      EXPECT_TRUE(std::filesystem::exists(folder / ("report/tables/" + table->id + ".csv")));
      EXPECT_TRUE(std::filesystem::exists(folder / ("report/tables/" + table->id + ".tex")));
    }
  EXPECT_THAT(markdown, HasSubstr("**simulated**"));
  for (const auto& path : report.written) EXPECT_TRUE(std::filesystem::exists(path)) << path;
}

TEST(Report, EqualResultsGiveEqualBytes) {
  const ScratchFolder folder;
  const std::vector<std::filesystem::path> results{
      results_in(folder, "results", hand_made_summary()),
      results_in(folder, "calibration", hand_made_calibration())};
  const ReportFiles first = write_report(results, folder / "first", {.made = "then"});
  write_report(results, folder / "second", {.made = "then"});
  for (const auto& path : first.written)
    EXPECT_TRUE(read_file(path) == read_file(folder / "second" / path.lexically_relative(folder / "first")))
        << path;
}

TEST(Report, WithoutAFixedTimeOnlyThePageTellsWhenItWasMade) {
  const ScratchFolder folder;
  const auto results = results_in(folder, "results", hand_made_summary());
  const ReportFiles first = write_report({results}, folder / "first", {.made = "once"});
  write_report({results}, folder / "second", {.made = "later"});
  for (const auto& path : first.written) {
    std::string later = read_file(folder / "second" / path.lexically_relative(folder / "first"));
    if (const auto at = later.find("later."); path.extension() == ".html" && at != std::string::npos)
      later.replace(at, 6, "once.");
    EXPECT_TRUE(read_file(path) == later) << path;
  }
}

TEST(Report, AUsedFolderLosesWhatTheLastReportWroteAndNothingElse) {
  const ScratchFolder folder;
  const auto accuracy = results_in(folder, "results", hand_made_summary());
  const auto calibration = results_in(folder, "calibration", hand_made_calibration());
  const ReportFiles first = write_report({accuracy}, folder / "report");
  write_file(folder / "report/mine.txt", "my notes");
  const ReportFiles second = write_report({calibration}, folder / "report");
  for (const auto& path : first.written) {
    const bool again = std::ranges::find(second.written, path) != second.written.end();
    EXPECT_EQ(std::filesystem::exists(path), again) << path;
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "report/mine.txt"));
  EXPECT_FALSE(std::filesystem::exists(folder / "report.partial"));
}

// Two that write into one folder would take each other's files.
TEST(Report, AFolderThatIsBeingWrittenIsRefusedAndStaysWhole) {
  const ScratchFolder folder;
  const auto results = results_in(folder, "results", hand_made_summary());
  ReportOptions options;
  options.made = "first";
  write_report({results}, folder / "report", options);
  options.made = "second";
  const std::string before = read_file(folder / "report/report.html");
  {
    const FolderLock other(partial_name(folder / "report"));
    EXPECT_THAT(message_of([&] { write_report({results}, folder / "report", options); }),
                HasSubstr("is being written by another process"));
    EXPECT_EQ(read_file(folder / "report/report.html"), before);
  }
  write_report({results}, folder / "report", options);
  EXPECT_NE(read_file(folder / "report/report.html"), before);
  EXPECT_FALSE(std::filesystem::exists(folder / "report.partial.lock"));
}

TEST(Report, AnUnfinishedRunIsNamed) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "results.partial");
  for (const char* given : {"results", "results.partial"})
    EXPECT_THAT(message_of([&] { write_report({folder / given}, folder / "report"); }),
                HasSubstr("results.partial: is what an unfinished run left"))
        << given;
}

TEST(Report, ProgressEndsWithAllOfIt) {
  const ScratchFolder folder;
  std::vector<double> shares;
  write_report({results_in(folder, "results", hand_made_summary())}, folder / "report",
               {.progress = [&](double share) { shares.push_back(share); }});
  ASSERT_FALSE(shares.empty());
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_DOUBLE_EQ(shares.back(), 1.0);
}

TEST(Report, ACalibrationComesWithItsFiguresAndTheirNumbers) {
  const ScratchFolder folder;
  const auto results = results_in(folder, "results", hand_made_calibration());
  const ReportFiles report = write_report({results}, folder / "report");
  EXPECT_EQ(report.tables, 4u);
  ASSERT_EQ(report.figures, 2u);
  const std::string markdown = read_file(folder / "report/report.md");
  EXPECT_THAT(markdown, HasSubstr("Calibration, **simulated**"));
  EXPECT_THAT(markdown, HasSubstr("50 samples inside give 0.73 +- 0.85 cm"));
  EXPECT_THAT(markdown,
              HasSubstr("0.80 cm (95 % interval 0.40 to 1.20 cm) of the distance and 2.00 cm (95 % interval "
                        "1.00 to 3.00 cm) in three dimensions, 3 of 4 answered"));
  const ReportContent content = read_report({results});
  for (const DrawnFigure& drawn : content.chapters.at(0).figures) {
    const std::filesystem::path path = folder / ("report/figures/" + drawn.figure.id);
    EXPECT_TRUE(read_file(path.string() + ".svg").ends_with("</svg>\n\n")) << path;
    EXPECT_TRUE(read_file(path.string() + ".pdf").starts_with("%PDF")) << path;
    EXPECT_EQ(read_file(path.string() + ".csv"), csv_of(drawn.figure));
  }
}

TEST(Report, FiguresOfSeveralResultsDoNotOverwriteEachOther) {
  const ScratchFolder folder;
  const auto results = results_in(folder, "results", hand_made_calibration());
  const ReportFiles report = write_report({results, results}, folder / "report");
  const std::set<std::filesystem::path> written(report.written.begin(), report.written.end());
  EXPECT_EQ(written.size(), report.written.size());
  EXPECT_EQ(report.figures, 4u);
}

TEST(Report, TablesOfSeveralResultsDoNotOverwriteEachOther) {
  const ScratchFolder folder;
  ResultsSummary other = hand_made_summary();
  other.study = "a/b";
  const auto first = results_in(folder, "first", hand_made_summary());
  const auto second = results_in(folder, "second", other);
  const ReportFiles report = write_report({first, second, second}, folder / "report");
  std::set<std::filesystem::path> written(report.written.begin(), report.written.end());
  EXPECT_EQ(written.size(), report.written.size());
  EXPECT_EQ(report.tables, 6u);
}

// Two nights, say, whose folders are called alike.
TEST(Report, ResultsOfOneNameAreToldApartByTheFoldersAroundThem) {
  const ScratchFolder folder;
  std::vector<std::filesystem::path> nights;
  for (const char* night : {"A", "B"}) {
    std::filesystem::create_directory(folder / night);
    nights.push_back(results_in(folder, std::string(night) + "/res", hand_made_summary()));
    write_file(nights.back() / "manifest.json",
               R"({"format": "trilat.manifest", "version": 1, "program": "trilat 9", "study": {"kind": )"
               R"("accuracy", "name": ")" +
                   hand_made_summary().study + R"(", "seed": 5}, "study_sha256": "ab"})");
  }
  nights.push_back(nights.front());
  const ReportFiles report = write_report(nights, folder / "AB");
  EXPECT_FALSE(std::filesystem::exists(folder / "AB.partial"));
  for (const char* study : {"A-res", "B-res", "A-res--2-"})
    EXPECT_TRUE(std::filesystem::exists(folder / "AB/studies" / (std::string(study) + ".json"))) << study;
  const std::set<std::filesystem::path> written(report.written.begin(), report.written.end());
  EXPECT_EQ(written.size(), report.written.size());
  for (const char* name : {": A/res\n", ": B/res\n", ": A/res (2)\n"})
    EXPECT_THAT(read_file(folder / "AB/report.md"), HasSubstr(name));
}

TEST(Report, WhatCannotBeWrittenToItsEndLeavesNothingAside) {
  const ScratchFolder folder;
  const auto results = results_in(folder, "results", hand_made_summary());
  std::filesystem::create_directories(folder / "report/report.html/mine");
  EXPECT_ANY_THROW(write_report({results}, folder / "report"));
  EXPECT_FALSE(std::filesystem::exists(folder / "report.partial"));
}

TEST(Report, ItsTablesCompile) {
  if (!std::filesystem::exists(kPdflatex)) GTEST_SKIP() << "pdflatex is not installed";
  const ScratchFolder folder;
  const auto plain = results_in(folder, "plain", hand_made_summary());
  const auto nasty = results_in(folder, "nasty", nasty_summary());
  CalibrationSummary calibration = hand_made_calibration();
  calibration.rigs.front().method = "50 % & $1 #2 a_b {c} ~d ^e \\f";
  const ReportFiles report =
      write_report({plain, nasty, results_in(folder, "calibration", calibration)}, folder / "report");
  std::string article =
      "\\documentclass{article}\n\\usepackage[utf8]{inputenc}\n\\usepackage[T1]{fontenc}\n"
      "\\usepackage{booktabs,longtable}\n\\begin{document}\n";
  for (const auto& path : report.written)
    if (path.string().find("/tables/") != std::string::npos && path.extension() == ".tex")
      article += "\\input{" + path.lexically_relative(folder / "report").string() + "}\n";
  write_file(folder / "report/article.tex", article + "\\end{document}\n");
  EXPECT_TRUE(compiles(folder / "report/article.tex")) << read_file(folder / "report/pdflatex.txt");
}

TEST(Report, AFolderThatHoldsNoResultsIsNamed) {
  const ScratchFolder folder;
  EXPECT_THAT(message_of([&] { write_report({folder / "absent"}, folder / "report"); }),
              HasSubstr("absent: does not exist; `trilat run` makes results folders"));
  EXPECT_FALSE(std::filesystem::exists(folder / "report"));
}

TEST(Report, AFileWhereTheFolderShouldBeIsNamed) {
  const ScratchFolder folder;
  write_file(folder / "report", "a file");
  const auto results = results_in(folder, "results", hand_made_summary());
  EXPECT_THAT(message_of([&] { write_report({results}, folder / "report"); }),
              HasSubstr("report: cannot be"));
}

}  // namespace
}  // namespace trilat
