// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/results/figure.h"
#include "datasets/results/summary.h"
#include "datasets/results/table.h"
#include "pipeline/accuracy/tracking_summary.h"

namespace trilat {

// The tables of an accuracy study. First the methods by joint and the errors by take; then all
// statistics, the paper's Table II when its activities were recorded, and the tracking of the sensors.
StoredTables accuracy_shown(const ResultsSummary& summary, const std::optional<TrackingSummary>& tracking);
// Methods by joint in each condition, and error against the number of sensors.
std::vector<Figure> accuracy_figures(const ResultsSummary& summary);

// One table a condition and alignment: every group and method with n, coverage, statuses and all statistics;
// behind it the differences from the reference, and behind those of a condition its whole bodies.
std::vector<Table> accuracy_tables(const ResultsSummary& summary);

// Methods by joint group, a table a condition, in the study's first alignment: mean errors with intervals,
// the best marked, and those that cannot be distinguished from it. The leading methods come first.
std::vector<Table> article_tables(const ResultsSummary& summary);
// Whether the paper's Table III may stand beside: walking, relative to the mean, against motion capture.
bool is_like_the_papers(const ResultsSummary& summary, const std::string& condition);

// Every method at every stage of a study, with its change from the stage before, participants paired; a table
// and a figure an activity. `stages`: the names in their order, at least one.
std::vector<Table> stages_tables(const ResultsSummary& summary, const std::vector<std::string>& stages);
// The reference's errors by stage, and the largest step; a sentence an activity.
std::vector<std::string> stages_findings(const ResultsSummary& summary,
                                         const std::vector<std::string>& stages);
// The warnings of the first stage, and takes that failed at any.
std::vector<std::string> stages_warnings(ResultsSummary summary, const std::vector<std::string>& stages);
std::vector<Figure> stages_figures(const ResultsSummary& summary, const std::vector<std::string>& stages);

// Errors of the leading methods by take, a table a condition, the largest error of the best method first.
// Empty without more than one take.
std::vector<Table> takes_tables(const ResultsSummary& summary);

// The paper's Table II beside ours: arms and legs, occluded samples and all. Empty for a study without them.
std::vector<Table> table2(const ResultsSummary& summary);

// Every method against the study's reference, by joint group. Without rows when there is nothing to compare.
Table differences_table(const ResultsSummary& summary, const std::string& condition,
                        const std::string& alignment);

// Methods of external files by alignment: error, bias and answers over all joints.
Table files_table(const ResultsSummary& summary, const std::string& condition);

// Whole bodies by method. Without rows when no method has any.
Table bodies_table(const ResultsSummary& summary, const std::string& condition);

// Each joint of each take by method, under the study's first alignment: takes, participants, joints and sides
// are group-bys of it.
std::vector<Table> joint_tables_by_take(const ResultsSummary& summary);

// Bias and 95 % limits of agreement by method, joint group and axis, under the alignments none and mean: a
// table a condition.
Table agreement_table(const ResultsSummary& summary, const std::string& condition,
                      const std::string& alignment);
std::vector<Table> agreement_tables(const ResultsSummary& summary);

// Joint angles by method, with ranges of motion and limits of agreement, and the figure of Bland and Altman;
// a table and a figure a condition whose takes have angles.
std::vector<Table> angle_tables(const ResultsSummary& summary);
std::vector<Figure> angle_figures(const ResultsSummary& summary);

// The Cramer-Rao bound of the ranges by joint group, and how far methods stay above it. Empty without truth.
std::vector<Table> bound_tables(const ResultsSummary& summary, const TrackingSummary& tracking);

// The tables on how the sensors tracked: the clocks' offset by motion, how sensors disagree, predictions.
// Tables without rows are left out.
std::vector<Table> tracking_tables(const TrackingSummary& summary);

// Everything that takes were checked by.
Table checks_table(const TrackingSummary& summary);

// How each sensor is turned, shifted and measures beside its calibration, a line a sensor.
std::vector<std::string> pose_lines(const std::vector<CheckRow>& checks);

// How well each method predicts the joints that a left-out sensor sees. No table when the study leaves none
// out.
std::vector<Table> prediction_tables(const ResultsSummary& summary);
// One take's disagreement along and across the rays, in one line.
std::string ray_text(const RayNoiseRow& row);

// The summary as it is shown: without the methods that stand for one of several sets of sensors, which the
// figure of numbers of sensors has together, and with one row for methods that answer alike everywhere, as
// the mean and the median of two sensors do. The rows by take stay whole.
ResultsSummary shown_summary(ResultsSummary summary);
// The method's name in a shown row: "mean = median" where both share it.
std::string row_name(const ResultsSummary& shown, const std::string& method);

// Whether the paper's nonlinear trilateration beats the plain mean when walking, yes or no; what
// trilateration reaches beside what the paper prints; what errs less; on which data.
std::vector<std::string> paper_comparison(const ResultsSummary& summary);

}  // namespace trilat
