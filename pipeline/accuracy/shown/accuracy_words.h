// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/summary.h"
#include "datasets/results/table.h"
#include "pipeline/accuracy/tracking_summary.h"

namespace trilat {

// Sentences that the tables of an accuracy study share.
// The limits of a study without mocap; empty with mocap.
std::string truth_note(const ResultsSummary& summary);
// The subject of a table: campaign, condition, sensors, alignment (unless empty), takes and participants.
std::string about(const ResultsSummary& summary, const std::string& condition, const std::string& alignment);
// How the intervals were made, or why there are none.
std::string interval_note(const ResultsSummary& summary);
// Below this share of the samples asked, a warning says that the error is of these only.
inline constexpr double kMinCoverage = 0.8;
// From this share on, every sample counts as answered.
inline constexpr double kWhole = 0.995;
// The notes of a table of errors: what its truth is, the notes of `key`, the intervals, one note for the
// methods that answer less than `kMinCoverage`, and the takes' own.
void add_error_notes(const ResultsSummary& summary, const std::string& condition,
                     const std::string& alignment, const std::string& key, Table& table);
void add_take_notes(const ResultsSummary& summary, Table& table);

// "4.9 cm (4.7 to 5.1)", without brackets where there is no interval.
std::string error_text(const Number& error);
// "57 % (47 to 67) less than `nonlinear`" of the average, or that both cannot be distinguished; empty for the
// reference itself and where there is no interval.
std::string difference_text(const ResultsSummary& summary, const std::string& condition,
                            const std::string& alignment, const std::string& method);

// The alignment that whole bodies are measured under: none where the study has it, else its first.
std::string body_alignment(const ResultsSummary& summary);

// One line a method that the first tables show: `name` and what it does.
std::vector<std::string> method_legend(const ResultsSummary& summary);

// A sentence a condition: which method errs least, by how much, against the reference, and what is like it,
// and how external methods do; `code` and **bold** as in Markdown.
std::vector<std::string> accuracy_findings(const ResultsSummary& summary);
// The warnings that a reader needs before believing a number: few participants, silent methods, disagreement
// with Ceres; and, where they are not said elsewhere, failed takes and notes of the checks.
std::vector<std::string> accuracy_warnings(const ResultsSummary& summary, bool with_notes = true);

}  // namespace trilat
