// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/base/json.h"
#include "datasets/results/results_file.h"
#include "datasets/results/summary.h"

namespace trilat {

// One number that a take was checked by. `what`, with its unit, is one of those that FORMATS.md lists; beyond
// its limit a note of the take names it, with the remedy, unless the note of another check explains it.
struct CheckRow {
  std::string take = {}, subject = {};           // a sensor, a joint, "mocap" or "all"
  std::string what = {}, unit = {};              // "m", "s", "rad", or "1" of a ratio
  double value = kNaN, low = kNaN, high = kNaN;  // 95 %, where that is known
  double limit = kNaN;
  bool beyond = false;

  static void fields(auto& self, auto&& f) {
    f("take", self.take, "subject", self.subject, "what", self.what, "unit", self.unit, "value", self.value,
      "low", self.low, "high", self.high, "limit", self.limit, "beyond", self.beyond);
  }
};

// The offset between mocap and sensors that the motion of one take shows: mocap time = stated + offset. It
// contains the trackers' lag.
struct ClockOffsetRow {
  std::string take;
  std::string status;
  double offset_s = kNaN, low_s = kNaN, high_s = kNaN;  // 95 %
  double drift_ppm = kNaN, drift_sigma_ppm = kNaN;
  double peak = kNaN, second = kNaN;  // correlation of speeds; the next peak as a share of it
  bool applied = false;

  static void fields(auto& self, auto&& f) {
    f("take", self.take, "status", self.status, "offset_s", self.offset_s, "low_s", self.low_s, "high_s",
      self.high_s, "drift_ppm", self.drift_ppm, "drift_sigma_ppm", self.drift_sigma_ppm, "peak", self.peak,
      "second", self.second, "applied", self.applied);
  }
};

// By how much the sensors of one take disagree along their rays and across, without what all sensors have in
// common. `problem` says why there are no numbers.
struct RayNoiseRow {
  std::string take;
  std::uint64_t rows = 0;  // instants of single joints
  std::string problem = {};
  double range_m = kNaN, bearing_m = kNaN;                   // standard deviations
  double ratio = kNaN, ratio_low = kNaN, ratio_high = kNaN;  // range / bearing, 95 %

  static void fields(auto& self, auto&& f) {
    f("take", self.take, "rows", self.rows, "problem", self.problem, "range_m", self.range_m, "bearing_m",
      self.bearing_m, "ratio", self.ratio, "ratio_low", self.ratio_low, "ratio_high", self.ratio_high);
  }
};

// The views of a joint group that a rule calls occluded, against those that truly hide the joint.
struct RuleRow {
  std::string condition, rule, group;
  std::uint64_t views = 0, hidden = 0, marked = 0, both = 0;

  static void fields(auto& self, auto&& f) {
    f("condition", self.condition, "rule", self.rule, "group", self.group, "views", self.views, "hidden",
      self.hidden, "marked", self.marked, "both", self.both);
  }
};

// Sums over the samples of a joint group that have a truth and three ranges that span space.
struct BoundRow {
  std::string condition, group;
  std::uint64_t n = 0, ranges = 0;
  double range_error_m2 = 0.0;  // squares of range less true distance
  double gdop = 0.0;            // at the truth: root of the trace of the bound for ranges of variance 1

  double range_error_m() const { return std::sqrt(range_error_m2 / static_cast<double>(ranges)); }
  double mean_gdop() const { return gdop / static_cast<double>(n); }
  double bound_m() const { return range_error_m() * mean_gdop(); }

  static void fields(auto& self, auto&& f) {
    f("condition", self.condition, "group", self.group, "n", self.n, "ranges", self.ranges, "range_error_m2",
      self.range_error_m2, "gdop", self.gdop);
  }
};

// tracking.json, beside an accuracy study's summary.json.
struct TrackingSummary {
  static constexpr const char* kFile = "tracking.json";
  std::string study;
  bool simulated = false;
  bool repaired = false;  // exchanges that were found were undone
  std::vector<CheckRow> checks = {};
  std::vector<ClockOffsetRow> clocks = {};
  std::vector<RayNoiseRow> rays = {};
  std::vector<RuleRow> rules = {};  // of simulations whose methods ask what is hidden
  std::vector<BoundRow> bounds = {};

  static void fields(auto& self, auto&& f) {
    f.format("trilat.tracking");
    f("study", self.study, "simulated", self.simulated, "repaired", self.repaired, "checks", self.checks,
      "clocks", self.clocks, "rays", self.rays, "rules", self.rules, "bounds", self.bounds);
  }
};

}  // namespace trilat
