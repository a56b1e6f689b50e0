// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace trilat {

inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

// Errors of one method in one condition, joint group and alignment. Distances in metres; NaN when nothing
// answered.
struct SummaryCell {
  std::string method;
  std::string condition;  // the takes' activity
  std::string group;      // a joint group, or a joint's own name when it belongs to none
  std::string alignment;
  std::uint64_t asked = 0;                        // instants and joints with ground truth
  std::uint64_t answered = 0;                     // of those, with a usable estimate; n of every number below
  std::map<std::string, std::uint64_t> statuses;  // how the asked ones ended; sums to asked
  double mae_m = kNoNumber;                       // mean Euclidean distance
  std::array<double, 3> axis_mae_m{kNoNumber, kNoNumber, kNoNumber};  // world x, y, z
  double rmse_m = kNoNumber;
  double median_m = kNoNumber;
  double p90_m = kNoNumber;
  double p95_m = kNoNumber;
  double max_m = kNoNumber;
  double mean_gdop = kNoNumber;
  double mean_iterations = kNoNumber;

  double coverage() const {
    return asked == 0 ? kNoNumber : static_cast<double>(answered) / static_cast<double>(asked);
  }
};

// One take that could not be evaluated, or something to know of one that was.
struct TakeNote {
  std::string take;
  bool failed = false;
  std::string place;
  std::string text;
};

// How far `nonlinear` and Ceres were apart on the well-posed samples.
struct CrossCheck {
  std::string method;
  std::uint64_t samples = 0;
  std::uint64_t disagreements = 0;  // one answered and the other did not
  double worst_m = 0.0;
  double limit_m = 0.0;
  std::string worst_at;
  bool passed() const { return disagreements == 0 && worst_m <= limit_m; }
};

struct ResultsSummary {
  std::string study;
  std::string campaign;
  bool simulated = false;
  std::uint64_t takes = 0;
  std::uint64_t takes_failed = 0;
  std::uint64_t participants = 0;
  std::vector<std::string> methods;     // in the order of the study
  std::vector<std::string> conditions;  // in the order of the takes
  std::vector<std::string> groups;
  std::vector<std::string> alignments;
  std::vector<SummaryCell> cells;
  std::vector<TakeNote> notes;
  std::optional<CrossCheck> cross_check;
};

// summary.json (results format 1, kind accuracy). NaN is written as null.
void write_summary(const std::filesystem::path& folder, const ResultsSummary& summary);
// Reads `folder`/summary.json; InputError when it is not there, of another version or kind, or
// not one.
ResultsSummary read_summary(const std::filesystem::path& folder);

// The cell of these four names, or none.
const SummaryCell* find_cell(const ResultsSummary& summary, const std::string& method,
                             const std::string& condition, const std::string& group,
                             const std::string& alignment);

}  // namespace trilat
