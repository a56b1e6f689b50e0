// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/results/studies/tracking_summary.h"
#include "datasets/results/summary.h"
#include "datasets/results/table.h"

namespace trilat {

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

// What a run says of how its sensors tracked: which views each rule rejects, by joint and by sensor;
// exchanges of left and right; the clocks' offset by motion. Tables without rows are left out.
std::vector<Table> tracking_tables(const TrackingSummary& summary);

// One sensor's correction in a line.
std::string correction_text(const CorrectionRow& row);

// Of a study that leaves sensors out: how well each method predicts what they see. One table or none.
std::vector<Table> prediction_tables(const TrackingSummary& summary);
// One take's disagreement along and across the rays, in one line.
std::string ray_text(const RayRow& row);

// The summary without the methods that stand for one of several sets of sensors: the figure of numbers of
// sensors has them together. The rows by take stay whole.
ResultsSummary without_sets(ResultsSummary summary);

}  // namespace trilat
