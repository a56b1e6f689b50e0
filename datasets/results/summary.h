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

#include "datasets/base/document.h"
#include "datasets/results/claims.h"
#include "datasets/results/numbers.h"
#include "datasets/results/results_file.h"

namespace trilat {

// The plain mean of the groups of a condition, as the paper's last row; counts are sums.
inline constexpr const char* kAverageGroup = "average";

// Sources of the truth of results.
inline constexpr const char* kMocapTruth = "mocap";
inline constexpr const char* kLeftOutTruth = "left_out_sensor";

// Name of the condition of the samples that at least one sensor sees occluded.
inline std::string occluded_condition(const std::string& activity) { return activity + ", occluded"; }

// One take that could not be evaluated, or something to know of one that was.
struct TakeNote {
  std::string take;
  bool failed = false;
  std::string place;
  std::string text;

  static void fields(auto& self, auto&& f) {
    f("take", self.take, "failed", self.failed, "place", self.place, "text", self.text);
  }
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

  static void fields(auto& self, auto&& f) {
    f("method", self.method, "samples", self.samples, "disagreements", self.disagreements, "lost", self.lost,
      "worst_m", self.worst_m, "limit_m", self.limit_m, "worst_at", self.worst_at);
    f.written("passed", self.passed());
  }
};

// One joint of one take and method under the study's first alignment.
struct TakeJointRow {
  std::string take, participant, condition, group, joint, method;
  std::uint64_t asked = 0, answered = 0;
  double mae_m = kNaN;
};

// The methods that one entry of a study became: one for each set of so many sensors.
struct SensorSetGroup {
  std::string name;
  std::uint64_t sensors = 0;  // in a set
  std::vector<std::string> methods;

  static void fields(auto& self, auto&& f) {
    f("name", self.name, "sensors", self.sensors, "methods", self.methods);
  }
};

inline constexpr double kSameDistance_m = 1e-6;

// Which method errs least in a condition and group, under the study's first alignment: of those that answer
// 95 % of what they are asked, if any does, and of sets of sensors none that has a family.
struct BestMethod {
  std::string condition, group, method;
  // The others that are not told apart from it by differs_significantly(), on the samples that both answer.
  // None where there is no interval.
  std::vector<std::string> not_distinguished;

  static void fields(auto& self, auto&& f) {
    f("condition", self.condition, "group", self.group, "method", self.method, "not_distinguished",
      self.not_distinguished);
  }
};

// One line on a method, for readers who do not know it.
struct MethodNote {
  std::string method, what;
  bool is_external = false;          // its joints came from a file of the takes
  std::vector<std::string> alike{};  // methods that share its row where results are shown; not stored

  static void fields(auto& self, auto&& f) {
    f("method", self.method, "what", self.what, "is_external", self.is_external);
  }
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
  std::vector<std::string> methods;      // in the order of the study
  std::vector<MethodNote> legend;        // one a method
  std::vector<SensorSetGroup> families;  // of some of them
  std::vector<BestMethod> best;
  std::string reference;                // the method that differences are against
  std::vector<std::string> conditions;  // in the order of the takes
  std::vector<std::string> groups;
  std::vector<std::string> alignments;
  std::map<std::string, std::string> group_of_joint, participant_of_take;
  std::map<std::string, std::string> clusters;  // of the intervals, by condition: "participants"
  std::vector<TakeNote> notes;
  std::string truth = kMocapTruth;
  std::vector<CrossCheck> cross_checks;  // one a method; empty when it was not asked for
  std::uint64_t rows = 0;                // of numbers.csv
  Numbers numbers = {};                  // which that file has

  // The truth is what each sensor sees, left out in turn.
  bool left_out() const { return truth == kLeftOutTruth; }
  // All methods that were compared with Ceres agree with it, and some were.
  bool cross_check_passed() const {
    return !cross_checks.empty() && std::ranges::all_of(cross_checks, &CrossCheck::passed);
  }

  static void fields(auto& self, auto&& f) {
    f("study", self.study, "campaign", self.campaign, "paper", self.paper, "simulated", self.simulated,
      "takes", self.takes, "takes_failed", self.takes_failed, "participants", self.participants, "methods",
      self.methods, "legend", self.legend, "families", self.families, "best", self.best, "reference",
      self.reference, "conditions", self.conditions, "groups", self.groups, "group_of_joint",
      self.group_of_joint, "participant_of_take", self.participant_of_take, "clusters", self.clusters,
      "alignments", self.alignments, "notes", self.notes, "truth", self.truth, "cross_checks",
      self.cross_checks, "rows", self.rows);
  }
  void check(const JsonPlace& place) const;
};

// Mean distance from the truth, with its interval; none where nothing is answered.
const Number* find_error(const ResultsSummary& summary, const std::string& method,
                         const std::string& condition, const std::string& group,
                         const std::string& alignment);
// Number of samples asked of a method and the share answered; none where nothing is asked.
const Number* find_coverage(const ResultsSummary& summary, const std::string& method,
                            const std::string& condition, const std::string& group,
                            const std::string& alignment);
double coverage_of(const ResultsSummary& summary, const std::string& method, const std::string& condition,
                   const std::string& group, const std::string& alignment);
// Method - reference in mean distance, over the samples that both answer; or as a share of the reference's.
const Number* find_difference(const ResultsSummary& summary, const std::string& method,
                              const std::string& condition, const std::string& group,
                              const std::string& alignment, const char* statistic = "difference");
// The interval of a difference leaves 0 out, by more than solvers that end at the same place differ.
inline bool is_significant(const Number& difference) {
  return difference.low > kSameDistance_m || difference.high < -kSameDistance_m;
}
// Each joint of each take, condition and method.
std::vector<TakeJointRow> rows_by_take(const ResultsSummary& summary);
void add_row(const TakeJointRow& row, ResultsSummary& summary);
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
// external ones, the paper's three, the best single sensor, mean, range_bearing, the reference and the best.
std::vector<std::string> leading_methods(const ResultsSummary& summary, const std::string& condition);

// Change of one method's mean error from one set of results to another, in one condition and joint group. The
// interval is of 95 %, by Student's t between participants.
struct ErrorChange {
  std::string condition, group, method;
  double before_m = kNaN, after_m = kNaN;
  double difference_m = kNaN, low_m = kNaN, high_m = kNaN;  // after - before
  double standard_error_m = kNaN, p_value = kNaN;           // two-sided, of so much without any change
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
