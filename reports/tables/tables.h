// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/paper/printed_tables.h"
#include "datasets/results/studies/calibration_summary.h"
#include "datasets/results/studies/recording_summary.h"
#include "datasets/results/studies/sweep_summary.h"
#include "datasets/results/studies/timings.h"
#include "datasets/results/studies/tracking_summary.h"
#include "datasets/results/summary.h"
#include "datasets/results/table.h"

namespace trilat {

// Adds the sentences of a section of notes.md, where {name} stands for what `names` has.
void add_notes(Table& table, const std::string& section,
               const std::map<std::string, std::string>& names = {});

// One table a condition and alignment: every group and method with n, coverage, statuses and all statistics;
// behind it the differences from the reference, and behind those of a condition its whole bodies.
std::vector<Table> accuracy_tables(const ResultsSummary& summary);

// Methods by joint group in one condition: mean errors with intervals, the best marked, and those that are
// not told apart from it. The leading methods come first; `with_paper`: the paper's Table III beside ours.
Table article_table(const ResultsSummary& summary, const std::string& condition, const std::string& alignment,
                    bool with_paper);
// One a condition, in the study's first alignment; the paper's beside the one that is like its own.
std::vector<Table> article_tables(const ResultsSummary& summary, bool with_paper);
// The paper's three, the best single sensor, the mean, range_bearing, the reference and the best; of few
// methods all. The least error first.
std::vector<std::string> leading_methods(const ResultsSummary& summary, const std::string& condition);
std::vector<std::string> by_error(const ResultsSummary& summary, const std::string& condition,
                                  std::vector<std::string> methods);
// The group that stands for all: their average, or the only one.
std::string average_group(const ResultsSummary& summary);
// Those with results, their average last.
std::vector<std::string> groups_in(const ResultsSummary& summary, const std::string& condition);
// Whether the paper's Table III may stand beside: walking, relative to the mean, against motion capture.
bool is_like_the_papers(const ResultsSummary& summary, const std::string& condition);
// The paper's Table III; NaN where it prints nothing.
double printed_table3_cm(const ResultsSummary& summary, const std::string& condition,
                         const std::string& group, const std::string& method);

// Which take or participant is odd: the leading methods' errors by take, the oddest first. Empty without more
// than one take.
std::vector<Table> oddity_tables(const ResultsSummary& summary);

// Two results of one study: what changed, the real changes first; and the sentences that lead.
Table changes_table(const ErrorChanges& changes);
std::vector<std::string> changes_sentences(const ErrorChanges& changes);

// The paper's Table II beside ours: arms and legs, occluded samples and all. Empty for a study without them.
std::vector<Table> table2(const ResultsSummary& summary);

// Every method against the study's reference, by joint group. Without rows when there is nothing to compare.
Table differences_table(const ResultsSummary& summary, const std::string& condition,
                        const std::string& alignment);

// Whole bodies by method. Without rows when no method has any.
Table bodies_table(const ResultsSummary& summary, const std::string& condition);

// Each joint of each take by method, under the study's first alignment: takes, participants, joints and sides
// are group-bys of it.
std::vector<Table> apart_tables(const ResultsSummary& summary);

// The tables of a calibration study beside the paper's statements; a part that was not run gives none.
std::vector<Table> calibration_tables(const CalibrationSummary& summary);

// Finding the wand: every method in every scene, and two of them by distance and by angle.
Table calibration_wand_table(const CalibrationSummary& summary);
Table calibration_bins_table(const CalibrationSummary& summary);
// A flat wall: the paper's bad columns against those between them, one row a unit.
Table calibration_distortion_table(const CalibrationSummary& summary);
// The poses of whole rigs, one row a method.
Table calibration_rigs_table(const CalibrationSummary& summary);

// What a run says of how its sensors tracked: which views each rule rejects, by joint and by sensor;
// exchanges of left and right; the clocks' offset by motion. Tables without rows are left out.
std::vector<Table> tracking_tables(const TrackingSummary& summary);

// One sensor's correction in a line.
std::string correction_text(const CorrectionRow& row);

// Of a study that leaves sensors out: how well each method predicts what they see. One table or none.
std::vector<Table> prediction_tables(const TrackingSummary& summary);
// One take's disagreement along and across the rays, in one line.
std::string ray_text(const RayRow& row);

// Table IV beside the paper's: clock errors, what the queue drops, what the corrected fit says of itself,
// and, where it was timed, what a frame costs.
std::vector<Table> table4(const RecordingSummary& summary, const std::optional<StageTimings>& timings);
// The paper's frames by processing time, or its samples by clock error, as ours are counted.
TimeSpread printed_table4_times(std::uint64_t PrintedTable4::Row::*count);

Table table4_clocks(const RecordingSummary& summary);
// `timings`: the share of the frames that are processed in time comes from them.
Table table4_queue(const RecordingSummary& summary, const std::optional<StageTimings>& timings);
Table table4_fits(const RecordingSummary& summary);
Table table4_processing(const StageTimings& timings);

// The paper's Table I beside ours, one table for each reading that was run with the printed and with the
// corrected gradient: propagation error, iterations and time of a solve. Empty when the sweep's thresholds or
// error ranges are not the paper's.
std::vector<Table> table1(const SweepSummary& summary, const std::optional<SweepTimings>& timings);

// The answer of an interpretation search: the readings that fit the printed errors best, those that fit the
// printed times, and what the smallest threshold costs with either gradient. Empty without a search.
std::vector<Table> search_tables(const SweepSummary& summary);

// Every number of every cell, with each of its settings in a column.
Table sweep_table(const SweepSummary& summary, const std::optional<SweepTimings>& timings);
// The readings worth a figure: all of a few, of many those that lead a ranking.
std::vector<std::size_t> readings_in_full(const SweepSummary& summary);

// Of a cell; none when it was not timed.
const SweepCellTiming* timing_of(const std::optional<SweepTimings>& timings, const SweepCell& cell);

// A sentence or two a person can take away from the search; empty without one.
std::vector<std::string> search_sentences(const SweepSummary& summary);

// The summary without the methods that stand for one of several sets of sensors: the figure of numbers of
// sensors has them together. The rows by take stay whole.
ResultsSummary without_sets(ResultsSummary summary);

}  // namespace trilat
