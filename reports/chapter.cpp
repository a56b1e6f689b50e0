// SPDX-License-Identifier: MIT
#include "reports/chapter.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/results/results_file.h"
#include "datasets/results/summary.h"
#include "reports/figures/figures.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/calibration_findings.h"
#include "reports/tables/sensor_counts.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

struct Answers {
  std::uint64_t asked = 0, answered = 0;
  std::map<std::string, std::uint64_t> statuses;
};

Answers answers_of(const ResultsSummary& s, const std::string& condition, const std::string& method) {
  Answers sum;
  for (const SummaryCell& c : s.cells) {
    if (c.condition != condition || c.method != method || c.alignment != s.alignments.front() ||
        c.group == kAverageGroup)
      continue;
    sum.asked += c.asked;
    sum.answered += c.answered;
    for (const auto& [status, n] : c.statuses) sum.statuses[status] += n;
  }
  return sum;
}

// How many samples each method answered in each condition, all joint groups together, and how all ended.
// Statuses do not depend on the alignment. Without rows when the results hold none.
Table coverage_table(const ResultsSummary& s) {
  Table table;
  table.id = usable_id("coverage-" + s.study);
  table.title = "Coverage and statuses by method, all joint groups together (" + about(s, "", "") + ")";
  table.columns = {{"condition", "condition", true},
                   {"method", "method", true},
                   {"asked", "asked", false},
                   {"n answered", "answered", false},
                   {"coverage (%)", "coverage_percent", false},
                   {"statuses", "statuses", true}};
  if (s.alignments.empty()) return table;
  for (const std::string& condition : s.conditions)
    for (const std::string& method : s.methods) {
      const Answers sum = answers_of(s, condition, method);
      if (sum.asked == 0) continue;
      table.rows.push_back({TableValue::of(condition), TableValue::of(method), count_cell(sum.asked),
                            count_cell(sum.answered), percent_cell(share_of(sum.answered, sum.asked)),
                            TableValue::of(statuses_text(sum.statuses, sum.asked))});
    }
  table.notes = {"Asked: instants and joints with ground truth. Answered: those with a usable estimate."};
  return table;
}

constexpr double kCompetes = 0.95;  // of what it is asked: to answer the easy samples alone wins nothing

// Of each condition which method errs least on average over the joint groups, how many others lie within its
// interval, and what that is against the reference.
std::vector<std::string> findings_of(const ResultsSummary& s) {
  std::vector<std::string> findings;
  if (s.alignments.empty()) return findings;
  const std::string group = s.groups.size() > 1 ? kAverageGroup : s.groups.empty() ? "" : s.groups[0];
  const auto is_ours = [&](const auto& row, const std::string& condition) {
    return row.condition == condition && row.group == group && row.alignment == s.alignments.front();
  };
  for (const std::string& condition : s.conditions) {
    std::vector<const SummaryCell*> cells;
    for (const SummaryCell& c : s.cells)
      if (is_ours(c, condition) && !std::isnan(c.mae_m)) cells.push_back(&c);
    const auto is_silent = [](const SummaryCell* c) { return !(c->coverage() >= kCompetes); };
    if (!std::ranges::all_of(cells, is_silent)) std::erase_if(cells, is_silent);
    if (cells.empty()) continue;
    const SummaryCell& best = **std::ranges::min_element(cells, {}, &SummaryCell::mae_m);
    const auto within = std::ranges::count_if(
        cells, [&](const SummaryCell* c) { return c != &best && c->mae_m <= best.mae_high_m; });
    std::string text = fmt::format("**{}**, {}: ", condition, s.simulated ? "simulated" : "recorded");
    const char* errs = s.left_out() ? "differs from the sensor left out" : "errs";
    if (cells.size() > 1) text += fmt::format("of {} methods ", cells.size());
    text += fmt::format("`{}` {}{} by {:.1f} cm", best.method, errs, cells.size() > 1 ? " least," : "",
                        best.mae_m * kCentimetresPerMetre);
    if (is_silent(&best)) text += fmt::format(" on the {:.0f} % that it answers", 100.0 * best.coverage());
    if (!std::isnan(best.mae_low_m))
      text += fmt::format(" (95 % interval {:.1f} to {:.1f}", best.mae_low_m * kCentimetresPerMetre,
                          best.mae_high_m * kCentimetresPerMetre) +
              (within == 0   ? ")"
               : within == 1 ? "; one other lies within it)"
                             : fmt::format("; {} others lie within it)", within));
    for (const DifferenceCell& d : s.differences)
      if (is_ours(d, condition) && d.method == best.method && best.method != s.reference)
        text += d.significant()
                    ? fmt::format(", {:+.0f} % ({:+.0f} to {:+.0f}) against `{}`", d.percent_of_reference,
                                  d.percent_low, d.percent_high, s.reference)
                    : fmt::format(", not told apart from `{}`", s.reference);
    findings.push_back(text + ".");
  }
  return findings;
}

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

Chapter accuracy_chapter(const std::filesystem::path& path) {
  const ResultsSummary s = without_sets(read_summary(path));
  Chapter chapter = new_chapter(path, s.study, s.campaign);
  chapter.title = s.study + " on " + s.campaign;
  chapter.simulated = s.simulated;
  chapter.about = fmt::format("{} of {} takes, {} participants, {}.", s.takes - s.takes_failed, s.takes,
                              s.participants, s.simulated ? "**simulated** sensors" : "recorded sensors");
  chapter.findings = findings_of(s);
  if (s.left_out()) chapter.sentences.push_back(truth_note(s));
  if (s.cross_check)
    chapter.sentences.push_back(fmt::format(
        "Cross-check of `{}` with Ceres: {} samples, worst difference {:.3g} m (limit {:g} m): {}.",
        s.cross_check->method, s.cross_check->samples, s.cross_check->worst_m, s.cross_check->limit_m,
        s.cross_check->passed() ? "agrees" : "**disagrees**"));
  append(chapter, table3(s));
  append(chapter, table2(s));
  append(chapter, sensor_counts_table(s));
  if (Table coverage = coverage_table(s); !coverage.rows.empty())
    append(chapter, std::vector{std::move(coverage)});
  chapter.first_tables = chapter.tables.size();
  append(chapter, accuracy_tables(s));
  chapter.apart = apart_tables(s);
  if (const auto tracking = read_tracking_summary(path)) {
    append(chapter, efficiency_tables(s, *tracking));
    append(chapter, tracking_tables(*tracking));
  }
  append(chapter, error_box_figures(s));
  append(chapter, sensor_counts_figure(s));
  append(chapter, trajectory_figures(path, s));
  if (const auto map = read_gdop_map(path)) append(chapter, std::vector{gdop_figure(*map, s)});
  chapter.replays = packed_replays(path, s);
  return chapter;
}

Chapter sweep_chapter(const std::filesystem::path& path) {
  const SweepSummary s = read_sweep_summary(path);
  const std::optional<SweepTimings> timings = read_sweep_timings(path);
  Chapter chapter = new_chapter(path, s.study);
  chapter.about = fmt::format(
      "Threshold sweep, **simulated**: {} readings x {} error ranges x {} thresholds, {} trials a cell.",
      s.interpretations.size(), s.ranges.size(), s.thresholds.size(), s.trials);
  chapter.sentences = search_sentences(s);
  append(chapter, table1(s, timings));
  append(chapter, search_tables(s));
  chapter.first_tables = chapter.tables.size();
  append(chapter, sweep_tables(s, timings));
  append(chapter, sweep_figures(s, timings));
  return chapter;
}

Chapter calibration_chapter(const std::filesystem::path& path) {
  const CalibrationSummary s = read_calibration_summary(path);
  Chapter chapter = new_chapter(path, s.study);
  chapter.about = fmt::format(
      "Calibration, **simulated** (seed {}): every number here is one of simulated depth images and "
      "sensors, except those that are called the paper's.",
      s.seed);
  chapter.sentences = calibration_sentences(s);
  append(chapter, calibration_tables(s));
  chapter.first_tables = chapter.tables.size();
  append(chapter, calibration_figures(s));
  return chapter;
}

Chapter budget_chapter(const std::filesystem::path& path) {
  const BudgetSummary s = read_budget_summary(path);
  Chapter chapter = new_chapter(path, s.study);
  chapter.about = fmt::format("Error budget of {}, **simulated**: {} participants, seed {}.", s.campaign,
                              s.participants, s.seed);
  append(chapter, budget_tables(s));
  append(chapter, budget_figures(s));
  chapter.first_tables = chapter.tables.size();
  return chapter;
}

Chapter sensitivity_chapter(const std::filesystem::path& path) {
  const SensitivitySummary s = read_sensitivity_summary(path);
  Chapter chapter = new_chapter(path, s.study);
  chapter.about = fmt::format(
      "Where conclusions hold, **simulated**: {} campaigns of {} participants over {} settings, seed {}.",
      s.points.size(), s.participants, s.factors.size(), s.seed);
  chapter.sentences = sensitivity_sentences(s);
  append(chapter, sensitivity_tables(s));
  append(chapter, sensitivity_figures(s));
  chapter.first_tables = 2;
  return chapter;
}

Chapter recording_chapter(const std::filesystem::path& path) {
  const RecordingSummary s = read_recording_summary(path);
  const std::optional<StageTimings> timings = read_stage_timings(path);
  Chapter chapter = new_chapter(path, s.study);
  chapter.about = fmt::format(
      "Clocks and processing times, **simulated** recordings (seed {}); the times that frames take are "
      "measured.",
      s.seed);
  append(chapter, table4(s, timings));
  append(chapter, clock_figures(s));
  chapter.first_tables = chapter.tables.size();
  return chapter;
}

Chapter twins_chapter(const std::filesystem::path& path) {
  const TwinsSummary s = read_twins_summary(path);
  Chapter chapter = new_chapter(path, s.study);
  chapter.about = fmt::format(
      "The simulator beside reality: **simulated** twins (seed {}) of **recorded** pairs of sensors.",
      s.seed);
  chapter.sentences = twins_sentences(s);
  append(chapter, twins_tables(s));
  chapter.first_tables = 1;
  append(chapter, twins_figures(s));
  return chapter;
}

}  // namespace

Chapter read_chapter(const std::filesystem::path& path) {
  switch (results_kind(path)) {
    case StudyKind::threshold_sweep:
      return sweep_chapter(path);
    case StudyKind::calibration:
      return calibration_chapter(path);
    case StudyKind::error_budget:
      return budget_chapter(path);
    case StudyKind::recording:
      return recording_chapter(path);
    case StudyKind::sensitivity:
      return sensitivity_chapter(path);
    case StudyKind::twins:
      return twins_chapter(path);
    case StudyKind::accuracy:
      break;
  }
  return accuracy_chapter(path);
}

}  // namespace trilat
