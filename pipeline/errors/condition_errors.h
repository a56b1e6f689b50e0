// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "datasets/results/stored_take.h"
#include "datasets/results/summary.h"
#include "datasets/results/take_errors.h"
#include "evaluators/metrics/statistics.h"
#include "pipeline/errors/take_errors.h"

namespace trilat {

// Distances from the truth of two methods on the samples that both answer, each aligned on just these: one
// that answers less would else be fitted to fewer samples, and look better for it. Sums over a block of time.
struct PairRow {
  std::uint32_t block = 0, quantity = 0, alignment = 0, subset = 0, n = 0;
  double first_m = 0.0, second_m = 0.0;
};

using MethodPair = std::pair<std::uint32_t, std::uint32_t>;  // places in the take's methods
using PairErrors = std::map<MethodPair, std::vector<PairRow>>;

// Errors of some pairs, from the samples; of each an entry, also without any. Reads the file three times,
// from memory where its samples are below 64 MB.
PairErrors pair_errors(const StoredTake& take, const ErrorSettings& settings,
                       std::span<const MethodPair> pairs);

// How the truth of a joint moves, and the errors of one method in the half of its samples with the larger
// acceleration and in the other half: numbers of samples and sums over a block of time.
struct MovementRow {
  std::uint32_t quantity = 0, block = 0, speeds = 0, abrupt = 0, calm = 0;
  double speed_m_s = 0.0, abrupt_m = 0.0, calm_m = 0.0;
};

// A row a joint and block, from the samples of the first track and how `table` lays the method's under the
// study's first alignment over the truth. Speeds are taken from the instants beside, accelerations from those
// a fifteenth of a second away, so that a marker's noise of some tenths of a millimetre does not decide them.
std::vector<MovementRow> movement_of(const StoredTake& take, const TakeErrors& table, std::size_t method,
                                     double rate_hz);

// A take that was evaluated, and the errors of its samples.
struct TakeTable {
  std::string id, participant, activity;
  TakeErrors errors;
  std::filesystem::path samples = {};      // its take.h5
  PairErrors pairs = {};                   // of the methods that are compared
  std::vector<MovementRow> movement = {};  // of nonlinear, where a claim of the paper asks for it
};

// Whether an alignment of that name counts the later part of a take alone, having learnt from the other.
bool leaves_training_out(const std::string& alignment);

// With fewer participants than this takes are the clusters of intervals.
inline constexpr std::size_t kMinParticipants = 3;

// The tables group, as of the paper, that a joint belongs to; its own name when it belongs to none.
std::string group_of(const std::string& joint);

// Each once, in the order of the joints.
std::vector<std::string> groups_of(const std::vector<std::string>& joints);

// A mean, as sums by cluster.
struct ClusterSums {
  std::vector<double> sum, n;
  void add(std::size_t cluster, double more, double count);
  void add(const ClusterSums& more);
  // Ratio of the sums of this many clusters.
  WeightedRatio ratio(std::size_t clusters, double weight = 1.0) const;
};

// One measure.
struct MeasureSums {
  std::uint64_t n = 0;
  double sum_abs = 0.0, largest = 0.0;
  ClusterSums sum, squares, absolute;

  void add(const ErrorSums& row, std::size_t cluster);
  double total() const;
  double total_squares() const;
};

// All samples of one group, method and alignment.
struct CellSums {
  std::uint64_t asked = 0, answered = 0, iterations = 0;
  std::array<std::uint64_t, kMaxStatuses> statuses{};
  MeasureSums distance;
  std::array<MeasureSums, 3> axes;
  std::vector<std::uint64_t> histogram;

  void add(const ErrorSums& row, std::size_t cluster);
  void add(const EndedRow& row);
  void add(std::span<const BinRow> bins);
  void add_counts(const CellSums& more);  // what is asked and answered, and how it ended
  // Type 7 of Hyndman and Fan 1996, with the samples of a bin spread evenly over it.
  double quantile_m(double q) const;
  // The samples whose error is less than so many bins.
  std::uint64_t below(std::size_t bins) const;

 private:
  double length_at(std::uint64_t place) const;
};

// Two methods on the samples that both answer.
struct PairSums {
  std::uint64_t n = 0;
  ClusterSums first_m, difference_m, second_m;  // difference: first - second
};

// Two methods on the samples that both answer: first - second, and that over the second's.
struct MethodDifference {
  std::uint64_t n = 0;
  Estimate m, share;
};

// The axes that the tables are grouped by. Joints are those of any track.
struct TableAxes {
  std::vector<std::string> groups;
  std::vector<std::size_t> group_of_joint;
  std::size_t methods = 0, alignments = 0;

  TableAxes(const std::vector<std::string>& joints, std::size_t methods, std::size_t alignments);
  std::size_t joint_of(const auto& row) const { return row.quantity % group_of_joint.size(); }
  std::size_t group_of(const auto& row) const { return group_of_joint[joint_of(row)]; }
};

// The samples of the takes of one activity, of one subset, by group, method and alignment, which are numbers.
// Clusters of intervals are the condition's participants; of fewer than three its takes; of a single take its
// blocks of time.
class ConditionErrors {
 public:
  ConditionErrors(std::span<const TakeTable> takes, const std::string& activity, Subset subset,
                  const TableAxes& axes);

  const std::vector<const TakeTable*>& takes() const { return takes_; }
  // Groups of joints of which any sample is asked.
  const std::vector<std::size_t>& groups() const { return groups_; }
  // "participants", "takes" or "blocks of time".
  const char* clusters() const { return cluster_kind_; }
  // Number of clusters. Cluster k is the same in every condition of the same takes and kind of cluster.
  std::size_t cluster_count() const { return cluster_count_; }

  const CellSums& cell(std::size_t group, std::size_t method, std::size_t alignment) const;
  // Two methods of pairs_of(): anything else is our bug.
  const PairSums& pair(std::size_t group, std::size_t first, std::size_t second, std::size_t alignment) const;

  // The plain mean of some groups' mean errors.
  Estimate mean_m(std::span<const std::size_t> groups, std::size_t method, std::size_t alignment) const;
  // Difference of two methods on the samples that both answer.
  MethodDifference difference(std::span<const std::size_t> groups, std::size_t first, std::size_t second,
                              std::size_t alignment) const;

  // Measures without joint group: of whole bodies, left-out sensors and angles, by the name of the angle. The
  // number behind the last method is the truth.
  const MeasureSums& other(const std::string& angle, std::size_t method, Measure measure) const;
  const std::vector<std::string>& angles() const { return angles_; }

 private:
  std::size_t place(std::size_t group, std::size_t method, std::size_t alignment) const;
  std::size_t place(std::size_t group, std::size_t first, std::size_t second, std::size_t alignment) const;
  void add(const TakeErrors& errors, Subset subset, std::size_t cluster, bool by_block);
  void add_sums(const TakeErrors& errors, const ErrorSums& row, Subset subset, std::size_t cluster);
  void add_pair(const MethodPair& pair, const PairRow& row, std::size_t cluster);

  const TableAxes& axes_;
  std::vector<const TakeTable*> takes_;
  const char* cluster_kind_ = "participants";
  std::size_t cluster_count_ = 0;
  std::vector<CellSums> cells_;
  std::vector<PairSums> pairs_;
  std::map<std::tuple<std::string, std::size_t, Measure>, MeasureSums> others_;
  std::vector<std::string> angles_;
  std::vector<std::size_t> groups_;
  std::set<MethodPair> compared_;
};

// The errors of a study's takes, by condition. Keeps references to the takes and to `names`, whose methods,
// alignments and number of participants it uses.
class StudyErrors {
 public:
  // `joints`: of the tables.
  StudyErrors(std::span<const TakeTable> takes, const std::vector<std::string>& joints,
              const ResultsSummary& names);

  std::span<const TakeTable> takes() const { return takes_; }
  const std::vector<std::string>& joints() const { return joints_; }
  const ResultsSummary& names() const { return names_; }
  const TableAxes& axes() const { return axes_; }
  // By the name of an activity or of its occluded samples; `subset` instead of all samples of an activity.
  ConditionErrors in(const std::string& condition, Subset subset = Subset::all) const;

 private:
  std::span<const TakeTable> takes_;
  const std::vector<std::string>& joints_;
  const ResultsSummary& names_;
  TableAxes axes_;
};

// Where the reference of a summary answers nothing in any take, the first method that does takes its place,
// and a note says so.
void set_reference(const StudyErrors& errors, ResultsSummary& summary);

// The pairs of methods whose errors on common samples are wanted: each with the reference, with those that
// err least in a condition and group, and with `more` methods, where the study has them.
std::vector<MethodPair> pairs_of(const StudyErrors& errors, const ResultsSummary& summary,
                                 std::span<const std::string> more);

// Adds to a summary that names its study's methods, families, conditions, groups, alignments and participants
// all numbers that follow from its takes' errors, in whose order sums are taken, and the best methods;
// `errors` has its names from the same summary, and its takes the errors of pairs_of().
void add_numbers(const StudyErrors& errors, ResultsSummary& summary);

}  // namespace trilat
