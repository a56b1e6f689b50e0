// SPDX-License-Identifier: MIT
#include "reports/write_report.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"
#include "datasets/results/summary.h"
#include "reports/accuracy_figures.h"
#include "reports/accuracy_tables.h"
#include "reports/audit.h"
#include "reports/budget_figures.h"
#include "reports/budget_tables.h"
#include "reports/calibration_figures.h"
#include "reports/calibration_findings.h"
#include "reports/calibration_tables.h"
#include "reports/claims.h"
#include "reports/clock_figures.h"
#include "reports/draw_figures.h"
#include "reports/efficiency.h"
#include "reports/gdop_figure.h"
#include "reports/parameters_table.h"
#include "reports/render.h"
#include "reports/sensor_counts.h"
#include "reports/sweep_figures.h"
#include "reports/sweep_tables.h"
#include "reports/table4.h"
#include "reports/tracking_tables.h"
#include "reports/trajectories.h"

namespace trilat {
namespace {

std::string heading_of(const ResultsSummary& s) {
  std::string text = fmt::format("## {} on {}\n\n{} of {} takes, {} participants, {}.\n", s.study, s.campaign,
                                 s.takes - s.takes_failed, s.takes, s.participants,
                                 s.simulated ? "**simulated** sensors" : "recorded sensors");
  if (s.cross_check)
    text += fmt::format(
        "\nCross-check of `{}` with Ceres: {} samples, worst difference {:.3g} m (limit {:g} m): {}.\n",
        s.cross_check->method, s.cross_check->samples, s.cross_check->worst_m, s.cross_check->limit_m,
        s.cross_check->passed() ? "agrees" : "**disagrees**");
  return text;
}

// Ids become file names, so two results of one kind must not share them.
void make_unique(std::string& id, std::set<std::string>& ids, const std::string& study) {
  if (ids.insert(id).second) return;
  const std::string base = usable_id(study + "-" + id);
  id = base;
  for (int n = 2; !ids.insert(id).second; ++n) id = fmt::format("{}-{}", base, n);
}

std::string heading_of(const SweepSummary& s) {
  std::string text = fmt::format(
      "## {}\n\nThreshold sweep, **simulated**: {} readings x {} error ranges x {} thresholds, {} trials a "
      "cell{}.\n",
      s.study, s.interpretations.size(), s.ranges.size(), s.thresholds.size(), s.trials,
      s.interrupted ? " (interrupted: some cells hold fewer)" : "");
  for (const std::string& sentence : search_sentences(s)) text += "\n" + sentence + "\n";
  return text;
}

std::string heading_of(const CalibrationSummary& s) {
  std::string text = fmt::format(
      "## {}\n\nCalibration, **simulated** (seed {}{}): every number here is one of simulated depth images "
      "and sensors, except those that are called the paper's.\n",
      s.study, s.seed, s.interrupted ? "; interrupted: some parts are missing" : "");
  for (const std::string& sentence : calibration_sentences(s)) text += "\n" + sentence + "\n";
  return text;
}

// What one results folder becomes.
struct Chapter {
  std::string study, heading;
  std::vector<Table> tables;
  std::vector<Figure> figures = {};
};

template <class T>
void append(std::vector<T>& all, std::vector<T> more) {
  for (T& one : more) all.push_back(std::move(one));
}

Chapter accuracy_chapter(const std::filesystem::path& path, ClaimEvidence& evidence) {
  const ResultsSummary summary = read_summary(path);
  evidence.add(summary);
  Chapter chapter{summary.study, heading_of(summary), table3(summary), sensor_counts_figure(summary)};
  append(chapter.figures, error_box_figures(summary));
  append(chapter.figures, trajectory_figures(path, summary));
  if (const auto map = read_gdop_map(path)) chapter.figures.push_back(gdop_figure(*map, summary));
  append(chapter.tables, table2(summary));
  append(chapter.tables, sensor_counts_table(summary));
  append(chapter.tables, accuracy_tables(summary));
  if (const auto tracking = read_tracking_summary(path)) {
    append(chapter.tables, efficiency_tables(summary, *tracking));
    append(chapter.tables, tracking_tables(*tracking));
  }
  return chapter;
}

Chapter sweep_chapter(const std::filesystem::path& path, ClaimEvidence& evidence) {
  const SweepSummary summary = read_sweep_summary(path);
  if (summary.search && !evidence.sweep) evidence.sweep = summary;
  const std::optional<SweepTimings> timings = read_sweep_timings(path);
  Chapter chapter{summary.study, heading_of(summary), table1(summary, timings),
                  sweep_figures(summary, timings)};
  append(chapter.tables, search_tables(summary));
  append(chapter.tables, sweep_tables(summary, timings));
  return chapter;
}

Chapter calibration_chapter(const std::filesystem::path& path, ClaimEvidence& evidence) {
  const CalibrationSummary summary = read_calibration_summary(path);
  if (!evidence.calibration) evidence.calibration = summary;
  return {summary.study, heading_of(summary), calibration_tables(summary), calibration_figures(summary)};
}

Chapter budget_chapter(const std::filesystem::path& path) {
  const BudgetSummary summary = read_budget_summary(path);
  return {summary.study,
          fmt::format("## {}\n\nError budget of {}, **simulated**: {} participants, seed {}.\n",
                      summary.study, summary.campaign, summary.participants, summary.seed),
          budget_tables(summary), budget_figures(summary)};
}

Chapter recording_chapter(const std::filesystem::path& path, ClaimEvidence& evidence) {
  const RecordingSummary summary = read_recording_summary(path);
  const std::optional<StageTimings> timings = read_stage_timings(path);
  if (!evidence.recording) evidence.recording = summary;
  if (!evidence.stages) evidence.stages = timings;
  return {summary.study,
          fmt::format("## {}\n\nClocks and processing times, **simulated** recordings (seed {}{}); the times "
                      "that frames take are measured.\n",
                      summary.study, summary.seed,
                      summary.interrupted ? "; interrupted: some parts are missing" : ""),
          table4(summary, timings), clock_figures(summary)};
}

Chapter chapter_of(const std::filesystem::path& path, ClaimEvidence& evidence) {
  switch (results_kind(path)) {
    case ResultsKind::threshold_sweep:
      return sweep_chapter(path, evidence);
    case ResultsKind::calibration:
      return calibration_chapter(path, evidence);
    case ResultsKind::error_budget:
      return budget_chapter(path);
    case ResultsKind::recording:
      return recording_chapter(path, evidence);
    case ResultsKind::accuracy:
      break;
  }
  return accuracy_chapter(path, evidence);
}

// Brackets in the text would end the picture's name.
std::string markdown_of(const Figure& figure) {
  std::string name;
  for (char c : figure.title) name += c == '[' || c == ']' ? std::string("\\") + c : std::string(1, c);
  return fmt::format("![{}]({}.svg)\n\n*{}*\n", name, figure.id, figure.caption);
}

// One table for all studies that assume the same.
std::vector<Table> parameter_tables(const std::vector<std::filesystem::path>& results) {
  std::vector<std::pair<std::vector<DeclaredParameter>, std::string>> seen;
  for (const auto& path : results) {
    const std::vector<DeclaredParameter> parameters = read_declared_parameters(path);
    if (parameters.empty()) continue;
    const std::string name = path.filename().empty() ? path.parent_path().filename() : path.filename();
    const auto same =
        std::find_if(seen.begin(), seen.end(), [&](const auto& other) { return other.first == parameters; });
    if (same == seen.end())
      seen.emplace_back(parameters, name);
    else
      same->second += ", " + name;
  }
  std::vector<Table> tables;
  for (const auto& [parameters, studies] : seen) tables.push_back(parameters_table(parameters, studies));
  return tables;
}

std::vector<std::string> remarks_on(const std::vector<Figure>& figures) {
  if (figures.empty()) return {};
  std::string names;
  for (const Figure& figure : figures) names += (names.empty() ? "" : ", ") + figure.id + ".svg";
  return {"Figures are left out here; they lie beside this document, each with its numbers as CSV: " + names +
          "."};
}

}  // namespace

ReportFiles write_report(const std::vector<std::filesystem::path>& results,
                         const std::filesystem::path& folder) {
  ReportFiles report;
  std::set<std::string> ids;
  std::string markdown = "# Trilateration accuracy\n";
  const auto add_table = [&](Table table, const std::string& study) {
    make_unique(table.id, ids, study);
    markdown += "\n" + markdown_of(table);
    report.tables.push_back(std::move(table));
  };
  std::vector<Chapter> chapters;
  ClaimEvidence evidence;
  for (const auto& path : results) chapters.push_back(chapter_of(path, evidence));
  if (evidence.is_of_the_paper()) {
    add_table(claims_table(evidence), "report");
    add_table(audit_table(), "report");
    add_table(errata_table(evidence), "report");
  }
  for (Chapter& chapter : chapters) {
    markdown += "\n" + chapter.heading;
    for (Table& table : chapter.tables) add_table(std::move(table), chapter.study);
    for (Figure& figure : chapter.figures) {
      make_unique(figure.id, ids, chapter.study);
      markdown += "\n" + markdown_of(figure);
      report.figures.push_back(std::move(figure));
    }
  }
  for (Table& table : parameter_tables(results)) add_table(std::move(table), "report");
  make_folder(folder);
  const auto write = [&](const std::string& name, const std::string& text) {
    write_file(folder / name, text);
    report.written.push_back(folder / name);
  };
  write("report.md", markdown);
  write("report.tex", latex_document(report.tables, remarks_on(report.figures)));
  for (const Table& table : report.tables) {
    write(table.id + ".csv", csv_of(table));
    write(table.id + ".tex", latex_of(table));
  }
  for (const DrawnFigure& drawn : draw_figures(report.figures)) {
    write(drawn.figure.id + ".svg", drawn.svg);
    write(drawn.figure.id + ".pdf", drawn.pdf);
    write(drawn.figure.id + ".csv", csv_of(drawn.figure));
  }
  return report;
}

}  // namespace trilat
