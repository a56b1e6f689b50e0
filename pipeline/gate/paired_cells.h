// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/gate/finding.h"
#include "pipeline/gate/paired_sums.h"

namespace trilat {

// What paired sums are of.
struct PairedStudy {
  std::string study;
  PairedAxes axes;
  std::vector<std::string> alignments, groups, methods;  // names, as long as the axes
  std::vector<PairedTake> takes;
};

struct PairedOptions {
  std::size_t resamples = 2000;
  // Whether both nights saw the same recordings, bit by bit.
  bool same_inputs = true;
};

// With fewer participants than this that both nights evaluated, and the same recordings, blocks of
// kLongBlock_s are the clusters: the answer is about these recordings, not about people. With fewer and other
// recordings participants stay the clusters, and hardly anything can be told apart.
inline constexpr std::size_t kFewestParticipants = 8;
inline constexpr std::size_t kLongBlock_s = 5;
// With fewer long blocks than this in all takes, blocks of kPairedBlock_s are.
inline constexpr std::size_t kFewestLongBlocks = 4;

// Every cell that is not identical, each group and their average, with 95 % intervals by solve_intervals()
// and the probability that so much is chance by Student's t of (clusters - 1) degrees on the same standard
// error. Threads do not change the result.
std::vector<ComparedCell> compared_cells(const PairedStudy& study, const PairedOptions& options);

}  // namespace trilat
