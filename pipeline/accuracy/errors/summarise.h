// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "datasets/results/error_table.h"
#include "datasets/results/summary.h"

namespace trilat {

// A take that was evaluated, and the errors of its samples.
struct TakeTable {
  std::string id, participant, activity;
  ErrorTable errors;
};

// With fewer participants than this takes are the clusters of intervals.
inline constexpr std::size_t kFewestParticipants = 3;

// The tables group, as of the paper, that a joint belongs to; its own name when it belongs to none.
std::string group_of(const std::string& joint);

// Each once, in the order of the joints.
std::vector<std::string> groups_of(const std::vector<std::string>& joints);

// Adds to a summary that names its study's methods, families, conditions, groups, alignments and participants
// all that follows from its takes' tables, in whose order sums are taken. Intervals are Student's t between
// participants; of fewer than three between takes, and of a single take between its blocks of time. When the
// reference answers nothing in any take, the first method that does takes its place, and a note says so.
// `joints`: of the tables.
void summarise(std::span<const TakeTable> takes, const std::vector<std::string>& joints,
               ResultsSummary& summary);

// The mean error of each method (row) over the samples that each other one (column) answers too, both aligned
// on these; of a method with itself over all its answers. In metres, the mean of the joint groups, of the
// takes of one activity; NaN where a group has no such sample, or the pair is in no table. One such matrix
// behind the other for each alignment.
std::vector<double> paired_errors_m(std::span<const TakeTable> takes, const std::vector<std::string>& joints,
                                    std::size_t methods, const std::string& activity);

}  // namespace trilat
