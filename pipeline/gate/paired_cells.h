// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "evaluators/metrics/cluster_ratios.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/gate/gate_report.h"

namespace trilat {

// Which cells two nights are compared in: alignment x set x group x method. Sets: all samples and, when the
// study has them apart, those that a sensor sees occluded. Alignments: that of the error column and, when the
// study has it beside, none.
struct PairedAxes {
  std::size_t alignments = 1, sets = 1, groups = 0, methods = 0;
  std::vector<std::size_t> group_of_joint;
  std::size_t cell(std::size_t alignment, std::size_t set, std::size_t group, std::size_t method) const {
    return ((alignment * sets + set) * groups + group) * methods + method;
  }
  std::size_t cells() const { return alignments * sets * groups * methods; }
};

// Columns of a cell's block sums. Over the samples that both nights answered: now - before of the error's
// length, their number, the lengths before; clamped now and not before, less the other way round. Over all
// that have a truth: answered before and not now, less the other way round; and their number.
struct PairedColumns {
  static constexpr std::size_t difference = 0, both = 1, before = 2, net_clamped = 3, net_lost = 4, asked = 5,
                               count = 6;
};

using StatusCounts = std::array<std::uint64_t, kSolveStatusCount>;

struct PairedCounts {
  std::uint64_t asked = 0, both = 0, lost = 0, gained = 0;
  StatusCounts status_before{}, status_now{};
  std::uint64_t answered_before() const { return both + lost; }
  std::uint64_t answered_now() const { return both + gained; }
  void merge(const PairedCounts& later);
};

// One take of both nights.
struct PairedTake {
  std::string id, participant, condition;
  RowMatrix sums;                   // blocks of kPairedBlock_s x (cells x PairedColumns)
  std::vector<PairedCounts> cells;  // by cell
};

inline constexpr double kPairedBlock_s = 1.0;

// One night's answer to a sample: the lengths of its error by alignment, in metres, NaN without an answer.
struct PairedAnswer {
  std::array<double, 2> error_m{};
  SolveStatus status = SolveStatus::not_solved;
};

// Adds samples to a take's sums.
class PairedTakeSums {
 public:
  PairedTakeSums(const PairedAxes& axes, std::uint64_t blocks);
  // The answers of one method for one joint at one instant. `sets`: how many sets the sample belongs to, from
  // the first on.
  void add(std::uint64_t block, std::size_t joint, std::size_t method, std::size_t sets,
           const PairedAnswer& before, const PairedAnswer& now);
  // Gives the sums away.
  void finish(PairedTake& take);

 private:
  const PairedAxes& axes_;
  RowMatrix sums_;
  std::vector<PairedCounts> counts_;
};

// What paired sums are of.
struct PairedStudy {
  std::string study;
  PairedAxes axes;
  std::vector<std::string> alignments, groups, methods;  // names, as long as the axes
  std::vector<PairedTake> takes;
};

struct PairedOptions {
  // Whether both nights saw the same recordings, bit by bit.
  bool same_inputs = true;
};

// With fewer participants than this that both nights evaluated, and the same recordings, blocks of
// kLongBlock_s are the clusters: the answer is about these recordings, not about people. With fewer and other
// recordings participants stay the clusters, and hardly anything can be told apart.
inline constexpr std::size_t kFewestJudged = 8;
inline constexpr std::size_t kLongBlock_s = 5;
// With fewer long blocks than this in all takes, blocks of kPairedBlock_s are.
inline constexpr std::size_t kFewestLongBlocks = 4;

// Every cell that is not identical, each group and their average, with 95 % intervals by student_intervals()
// and the probability that so much is chance by Student's t of (clusters - 1) degrees on the same standard
// error. Threads do not change the result.
std::vector<ComparedCell> compared_cells(const PairedStudy& study, const PairedOptions& options);

}  // namespace trilat
