// SPDX-License-Identifier: MIT
#include "reports/chapter.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/results/results_file.h"
#include "datasets/results/studies/variations_summary.h"
#include "datasets/results/summary.h"
#include "datasets/results/table.h"
#include "reports/figures/figures.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/calibration_findings.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

constexpr std::size_t kFirstFigures = 3, kMostCells = 200;

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
  // of the paper's studies one asks what compensation does, and some what more sensors do
  const std::vector<Table> second = paper ? table2(s) : std::vector<Table>{};
  const bool counts_sensors = paper && !sensor_counts_figure(s).empty();
  append(chapter, second);
  if (chapter.tables.empty()) append(chapter, article_tables(s, paper));
  if (!paper) append(chapter, oddity_tables(s));
  chapter.first_tables = chapter.tables.size();
  if (!second.empty() || counts_sensors) append(chapter, article_tables(s, false));
  append(chapter, accuracy_tables(s));
  chapter.apart = apart_tables(s);
  if (tracking) append(chapter, tracking_tables(*tracking));
  for (const std::string& condition : s.conditions)
    append(chapter, std::vector{methods_figure(s, condition, paper && is_like_the_papers(s, condition))});
  append(chapter, sensor_counts_figure(s));
  append(chapter, trajectory_figures(path, s));
  chapter.first_figures = std::min<std::size_t>(chapter.figures.size(), kFirstFigures);
  chapter.replays = packed_replays(path, s);
  return chapter;
}

Chapter sweep_chapter(const std::filesystem::path& path, bool) {
  const SweepSummary s = read_results<SweepSummary>(path);
  const std::optional<SweepTimings> timings = read_beside<SweepTimings>(path);
  Chapter chapter = new_chapter(path, s.study);
  chapter.about = fmt::format(
      "Threshold sweep, **simulated**: {} readings x {} error ranges x {} thresholds, {} trials a cell.",
      s.interpretations.size(), s.ranges.size(), s.thresholds.size(), s.trials);
  chapter.sentences = search_sentences(s);
  chapter.findings = chapter.sentences;
  if (!s.search) append(chapter, table1(s, timings));
  append(chapter, search_tables(s));
  chapter.first_tables = chapter.tables.size();
  if (s.search) append(chapter, table1(s, timings));
  Table cells = sweep_table(s, timings);
  (cells.rows.size() > kMostCells ? chapter.apart : chapter.tables).push_back(std::move(cells));
  append(chapter, sweep_figures(s, timings));
  chapter.first_figures = s.search ? 0 : 2;
  return chapter;
}

Chapter calibration_chapter(const std::filesystem::path& path, bool) {
  const CalibrationSummary s = read_results<CalibrationSummary>(path);
  Chapter chapter = new_chapter(path, s.study);
  chapter.about = fmt::format(
      "Calibration, **simulated** (seed {}): every number here is one of simulated depth images and sensors, "
      "except those that are called the paper's.",
      s.seed);
  chapter.sentences = calibration_sentences(s);
  append(chapter, calibration_tables(s));
  chapter.first_tables = std::min<std::size_t>(2, chapter.tables.size());
  append(chapter, calibration_figures(s));
  chapter.first_figures = 1;
  return chapter;
}

// As it was stored.
Chapter variations_chapter(const std::filesystem::path& path, bool) {
  const VariationsSummary s = read_results<VariationsSummary>(path);
  Chapter chapter = new_chapter(path, s.study);
  chapter.about = fmt::format(
      "Variations of a simulation, **simulated**: {} campaigns of {} participant{} each, seed {}.",
      s.points.size(), s.participants, s.participants == 1 ? "" : "s", s.seed);
  chapter.sentences = s.sentences;
  chapter.findings = s.sentences;
  if (const auto stored = read_beside<StoredTables>(path)) append(chapter, stored->tables);
  if (const auto stored = read_beside<StoredFigures>(path)) append(chapter, stored->figures);
  chapter.first_tables = 1;
  chapter.first_figures = 1;
  return chapter;
}

Chapter recording_chapter(const std::filesystem::path& path, bool) {
  const RecordingSummary s = read_results<RecordingSummary>(path);
  const std::optional<StageTimings> timings = read_beside<StageTimings>(path);
  Chapter chapter = new_chapter(path, s.study);
  chapter.about = fmt::format(
      "Clocks and processing times, **simulated** recordings (seed {}); the times that frames take are "
      "measured.",
      s.seed);
  append(chapter, table4(s, timings));
  chapter.first_tables = 2;
  return chapter;
}

}  // namespace

Chapter read_chapter(const std::filesystem::path& path, bool paper) {
  static const std::map<StudyKind, Chapter (*)(const std::filesystem::path&, bool)> kChapters{
      {StudyKind::accuracy, accuracy_chapter},
      {StudyKind::threshold_sweep, sweep_chapter},
      {StudyKind::calibration, calibration_chapter},
      {StudyKind::recording, recording_chapter},
      {StudyKind::variations, variations_chapter}};
  Chapter chapter = kChapters.at(results_kind(path))(path, paper);
  chapter.first_tables = std::min(chapter.first_tables, chapter.tables.size());
  chapter.first_figures = std::min(chapter.first_figures, chapter.figures.size());
  return chapter;
}

}  // namespace trilat
