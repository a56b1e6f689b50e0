// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/results/claims.h"
#include "datasets/results/results_file.h"

namespace trilat {

inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

struct Estimate {  // with its 95 % interval; NaN where there is none
  double value = kNoNumber, low = kNoNumber, high = kNoNumber;

  static constexpr bool as_list = true;
  TRILAT_FIELDS(value, low, high)
};

// The plain mean of the groups of a condition, as the paper's last row: mae_m and its interval; counts are
// sums, all other numbers NaN.
inline constexpr const char* kAverageGroup = "average";

// Where the truth of results comes from.
inline constexpr const char* kMocapTruth = "mocap";
inline constexpr const char* kLeftOutTruth = "left_out_sensor";

// Of the samples of an activity's takes that at least one sensor sees occluded.
inline std::string occluded_condition(const std::string& activity) { return activity + ", occluded"; }

// Errors of one method in one condition, joint group and alignment. Distances in metres; NaN when nothing
// answered.
struct SummaryCell {
  std::string method;
  std::string condition;  // the takes' activity, or occluded_condition() of it
  std::string group;      // a joint group, a joint's own name when it belongs to none, or kAverageGroup
  std::string alignment;
  std::uint64_t asked = 0;                        // instants and joints with ground truth
  std::uint64_t answered = 0;                     // of those, with a usable estimate; n of every number below
  std::map<std::string, std::uint64_t> statuses;  // how the asked ones ended; sums to asked
  double mae_m = kNoNumber;                       // mean Euclidean distance
  std::array<double, 3> axis_mae_m{kNoNumber, kNoNumber, kNoNumber};  // world x, y, z
  std::array<double, 3> bias_m{kNoNumber, kNoNumber, kNoNumber};      // mean of estimate - truth, the same
  double rmse_m = kNoNumber;
  double p05_m = kNoNumber;
  double p25_m = kNoNumber;
  double median_m = kNoNumber;
  double p75_m = kNoNumber;
  double p90_m = kNoNumber;
  double p95_m = kNoNumber;
  double max_m = kNoNumber;
  double mean_iterations = kNoNumber;  // of all that is asked, also where the limit was reached
  // 95 % interval of mae_m, participants as clusters; NaN when fewer than two answered.
  double mae_low_m = kNoNumber;
  double mae_high_m = kNoNumber;
  std::uint64_t clusters = 0;  // participants with an answered sample

  double coverage() const {
    return asked == 0 ? kNoNumber : static_cast<double>(answered) / static_cast<double>(asked);
  }

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(method, condition, group, alignment, asked, answered)
    field("coverage", self.coverage());
    TRILAT_EACH(statuses, mae_m, axis_mae_m, bias_m, rmse_m, p05_m, p25_m, median_m, p75_m, p90_m, p95_m,
                max_m, mean_iterations, mae_low_m, mae_high_m, clusters)
  }
};

// One take that could not be evaluated, or something to know of one that was.
struct TakeNote {
  std::string take;
  bool failed = false;
  std::string place;
  std::string text;

  TRILAT_FIELDS(take, failed, place, text)
};

// How far an iterative method and Ceres were apart on the well-posed samples. Nothing compared is no
// agreement.
struct CrossCheck {
  std::string method;
  std::uint64_t samples = 0;
  std::uint64_t disagreements = 0;  // one answered and the other did not
  std::uint64_t lost = 0;           // Ceres found a lower objective
  double worst_m = 0.0;
  double limit_m = 0.0;
  std::string worst_at;
  bool passed() const { return samples > 0 && disagreements + lost == 0 && worst_m <= limit_m; }

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(method, samples, disagreements, lost, worst_m, limit_m, worst_at)
    field("passed", self.passed());
  }
};

inline constexpr double kSameDistance_m = 1e-6;

// One method against the study's reference, over the samples that both answered: differences are taken sample
// by sample, method - reference, before they are averaged. Intervals are 95 %, participants as clusters; NaN
// when fewer than two answered.
struct DifferenceCell {
  std::string method;
  std::string condition;
  std::string group;
  std::string alignment;
  std::uint64_t n = 0;  // samples that both answered
  std::uint64_t clusters = 0;
  double difference_m = kNoNumber;
  double low_m = kNoNumber;
  double high_m = kNoNumber;
  double percent_of_reference = kNoNumber;  // 100 (method - reference) / reference
  double percent_low = kNoNumber;           // interval of percent_of_reference
  double percent_high = kNoNumber;
  double percent_of_method = kNoNumber;  // 100 (method - reference) / method
  // The interval leaves 0 out, by more than solvers that end at the same place differ.
  bool significant() const { return low_m > kSameDistance_m || high_m < -kSameDistance_m; }

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(method, condition, group, alignment, n, clusters, difference_m, low_m, high_m)
    field("significant", self.significant());
    TRILAT_EACH(percent_of_reference, percent_low, percent_high, percent_of_method)
  }
};

// A method's whole bodies. An instant counts when every joint that has a truth is answered, in mpjpe_m also
// after the alignment; in PCK what is not answered counts as wrong. All but mpjpe_m and PCK are of estimates
// before alignment.
struct BodyCell {
  std::string method;
  std::string condition;
  std::string alignment;       // of mpjpe_m and PCK: the study's first
  std::uint64_t instants = 0;  // that mpjpe_m is the mean of
  std::uint64_t clusters = 0;
  double mpjpe_m = kNoNumber;
  double mpjpe_low_m = kNoNumber;
  double mpjpe_high_m = kNoNumber;
  double pa_mpjpe_m = kNoNumber;
  double pa_mpjpe_low_m = kNoNumber;
  double pa_mpjpe_high_m = kNoNumber;
  std::array<double, 3> pck{kNoNumber, kNoNumber, kNoNumber};  // share of joints within 5, 10 and 15 cm
  std::uint64_t bones = 0;                                     // whose both ends are evaluated
  double bone_length_sd_m = kNoNumber;                         // over a take, mean over bones and takes
  double jitter_m_s3 = kNoNumber;                              // mean length of the jerk
  double truth_jitter_m_s3 = kNoNumber;

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(method, condition, alignment, instants, clusters, mpjpe_m, mpjpe_low_m, mpjpe_high_m,
                pa_mpjpe_m, pa_mpjpe_low_m, pa_mpjpe_high_m)
    field("pck_5cm_10cm_15cm", self.pck);
    TRILAT_EACH(bones, bone_length_sd_m, jitter_m_s3, truth_jitter_m_s3)
  }
};

// One joint of one take and method under the study's first alignment: where an odd take, person or side
// shows.
struct TakeJointRow {
  std::string take, participant, condition, group, joint, method;  // condition and group: as of a SummaryCell
  std::uint64_t asked = 0, answered = 0;
  double mae_m = kNoNumber;

  TRILAT_FIELDS(take, participant, condition, group, joint, method, asked, answered, mae_m)
};

// The methods that one entry of a study became: one for each set of so many sensors.
struct MethodFamily {
  std::string name;
  std::uint64_t sensors = 0;  // in a set
  std::vector<std::string> methods;

  TRILAT_FIELDS(name, sensors, methods)
};

// A family in one condition, on average over the joint groups, under the study's first alignment; intervals
// are Student's, participants as clusters.
struct FamilyCell {
  std::string family, condition;
  double mae_m = kNoNumber, low_m = kNoNumber, high_m = kNoNumber;  // over what its methods answer
  double answered = kNoNumber;                                      // share of what they are asked

  TRILAT_FIELDS(family, condition, mae_m, low_m, high_m, answered)
};

// Which method errs least in a condition and group, under the study's first alignment: of those that answer
// 95 % of what they are asked, if any does, and of sets of sensors none that has a family.
struct BestMethod {
  std::string condition, group, method;
  // The others that are not told apart from it by is_told_apart(), on the samples that both answer. None
  // where there is no interval.
  std::vector<std::string> like_best;

  TRILAT_FIELDS(condition, group, method, like_best)
};

// One line on a method, for readers who do not know it.
struct MethodNote {
  std::string method, what;
  bool is_brought = false;           // its joints came from a file of the takes
  std::vector<std::string> alike{};  // methods that share its row where results are shown; not stored

  TRILAT_FIELDS(method, what, is_brought)
};

struct ResultsSummary {
  static constexpr StudyKind kKind = StudyKind::accuracy;
  std::string study;
  std::string campaign;
  std::string paper = name_of(PaperStudy::none);
  bool simulated = false;
  std::uint64_t takes = 0;
  std::uint64_t takes_failed = 0;
  std::uint64_t participants = 0;
  std::vector<std::string> methods;    // in the order of the study
  std::vector<MethodNote> legend;      // one a method
  std::vector<MethodFamily> families;  // of some of them
  std::vector<FamilyCell> family_cells;
  std::vector<BestMethod> best;
  std::string reference;                // the method that differences are against
  std::vector<std::string> conditions;  // in the order of the takes
  std::vector<std::string> groups;
  std::vector<std::string> alignments;
  std::vector<SummaryCell> cells;
  std::vector<DifferenceCell> differences;
  std::vector<BodyCell> bodies;
  std::vector<TakeJointRow> by_take;  // takes, in each condition, joint, method
  std::vector<TakeNote> notes;
  std::string truth = kMocapTruth;
  std::vector<CrossCheck> cross_checks;  // one a method; empty when it was not asked for
  std::vector<ClaimNumber> claims = {};  // of the paper, that the study bears on

  // The truth is what each sensor sees, left out in turn.
  bool left_out() const { return truth == kLeftOutTruth; }
  // All methods that were compared with Ceres agree with it, and some were.
  bool cross_check_passed() const {
    return !cross_checks.empty() && std::ranges::all_of(cross_checks, &CrossCheck::passed);
  }

  TRILAT_FIELDS(study, campaign, paper, simulated, takes, takes_failed, participants, methods, legend,
                families, family_cells, best, reference, conditions, groups, alignments, cells, differences,
                bodies, by_take, notes, truth, cross_checks, claims)
  void check(const JsonObject& object) const;
};

// summary.json (kind accuracy). NaN is written as null.
void write_summary(const std::filesystem::path& folder, const ResultsSummary& summary);
// Reads `folder`/summary.json; InputError when it is not there, of another version or kind, or not one.
ResultsSummary read_summary(const std::filesystem::path& folder);

// The cell of these four names, or none.
const SummaryCell* find_cell(const ResultsSummary& summary, const std::string& method,
                             const std::string& condition, const std::string& group,
                             const std::string& alignment);
// The method's difference from the reference, or none.
const DifferenceCell* find_difference(const ResultsSummary& summary, const std::string& method,
                                      const std::string& condition, const std::string& group,
                                      const std::string& alignment);
const BestMethod* find_best(const ResultsSummary& summary, const std::string& condition,
                            const std::string& group);

// The group that stands for all: their average, or the only one.
std::string average_group(const ResultsSummary& summary);
// The joint groups that have results, and their average last.
std::vector<std::string> groups_in(const ResultsSummary& summary, const std::string& condition);
// The methods sorted by their mean error under the first alignment, the least first.
std::vector<std::string> by_error(const ResultsSummary& summary, const std::string& condition,
                                  std::vector<std::string> methods);
// The methods that a study shows first, the smallest error first: all where there are at most eight, else the
// brought ones, the paper's three, the best single sensor, mean, range_bearing, the reference and the best.
std::vector<std::string> leading_methods(const ResultsSummary& summary, const std::string& condition);

// What one method's mean error did from one set of results to another, in one condition and joint group. The
// interval is of 95 %, by Student's t between participants.
struct ErrorChange {
  std::string condition, group, method;
  double before_m = kNoNumber, after_m = kNoNumber;
  double difference_m = kNoNumber, low_m = kNoNumber, high_m = kNoNumber;  // after - before
  double standard_error_m = kNoNumber, chance = kNoNumber;  // two-sided, of so much without any change
  std::size_t clusters = 0, degrees = 0;                    // of freedom; 0: no interval
  std::vector<std::string> without{};  // groups that the average leaves out: one side does not answer them
  bool is_real() const { return low_m > kSameDistance_m || high_m < -kSameDistance_m; }
};

struct ErrorChanges {
  std::string before, after;     // the folders' names
  bool paired = false;           // the same participants in both: their differences are what is averaged
  std::size_t participants = 0;  // of the fewer
  std::vector<ErrorChange> rows;
};

}  // namespace trilat
