// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/document.h"

namespace trilat {

// Table I as the paper prints it. The paper does not say in which unit C is.
struct PrintedTable1 {
  struct Row {
    double threshold = 0.0;        // C
    std::vector<double> error_cm;  // by range
    std::vector<double> time_us;   // by range
    bool time_is_below = false;    // printed as "<" that time
    static void fields(auto& self, auto&& f) {
      f("threshold", self.threshold, "error_cm", self.error_cm, "time_us", self.time_us, "time_is_below",
        self.time_is_below);
    }
  };
  std::string source, metric;
  std::vector<std::array<double, 2>> ranges_cm;
  std::vector<Row> rows;
  static void fields(auto& self, auto&& f) {
    f("source", self.source, "metric", self.metric, "ranges_cm", self.ranges_cm, "rows", self.rows);
  }
};

PrintedTable1 printed_table1();

// Table III as the paper prints it, centimetres. The printed averages differ from those of its rows (erratum
// E13).
struct PrintedTable3 {
  struct Row {
    std::string group;           // head, shoulder, elbow, wrist, average
    std::vector<double> mae_cm;  // by method
    static void fields(auto& self, auto&& f) { f("group", self.group, "mae_cm", self.mae_cm); }
  };
  std::string source, metric;
  std::vector<std::string> methods;  // linear, geometric, nonlinear
  std::vector<Row> rows;
  static void fields(auto& self, auto&& f) {
    f("source", self.source, "metric", self.metric, "methods", self.methods, "rows", self.rows);
  }
};

PrintedTable3 printed_table3();
// Printed number of a group and method; NaN where it prints nothing. `groups`: those beside which it stands,
// "average" among them; its average is that of its own groups and of no others.
double printed_cm(const PrintedTable3& table, const std::vector<std::string>& groups,
                  const std::string& group, const std::string& method);

// Statements of the paper about its calibration. It prints no table of it, and the data of its two figures
// are not available.
struct PrintedCalibration {
  std::string source, metric;
  int samples = 0;
  std::array<double, 2> recommended_m{};
  double recommended_below_deg = 0.0;
  int recommended_samples = 0;
  double recommended_mean_cm = 0.0;
  double recommended_spread_cm = 0.0;  // behind the "+-"; what it is, is not said
  double near_m = 0.0;
  double near_valid_percent = 0.0;
  double wall_m = 0.0;
  int wall_frames = 0;
  std::vector<std::array<double, 2>> worse_columns;  // as printed: the last ends beyond the image
  std::string worse;                                 // how the paper calls the error there
  static void fields(auto& self, auto&& f) {
    f("source", self.source, "metric", self.metric, "samples", self.samples, "recommended_m",
      self.recommended_m, "recommended_below_deg", self.recommended_below_deg, "recommended_samples",
      self.recommended_samples, "recommended_mean_cm", self.recommended_mean_cm, "recommended_spread_cm",
      self.recommended_spread_cm, "near_m", self.near_m, "near_valid_percent", self.near_valid_percent,
      "wall_m", self.wall_m, "wall_frames", self.wall_frames, "worse_columns", self.worse_columns, "worse",
      self.worse);
  }
};

PrintedCalibration printed_calibration();

// Table II as the paper prints it, centimetres: joints that are occluded, with and without compensation.
struct PrintedTable2 {
  struct Row {
    std::string part;       // arms, legs
    std::string condition;  // our activity
    std::vector<std::string> groups;
    double with_cm = 0.0, without_cm = 0.0;
    static void fields(auto& self, auto&& f) {
      f("part", self.part, "condition", self.condition, "groups", self.groups, "with_cm", self.with_cm,
        "without_cm", self.without_cm);
    }
  };
  std::string source, metric;
  std::vector<Row> rows;
  static void fields(auto& self, auto&& f) {
    f("source", self.source, "metric", self.metric, "rows", self.rows);
  }
};

PrintedTable2 printed_table2();

// Table IV as the paper prints it, from the longest range to the shortest. The printed shares below 2 ms and
// the sum of its samples contradict it (erratum E14).
struct PrintedTable4 {
  struct Row {
    double from_ms = 0.0, to_ms = 0.0;  // the first has no end: NaN
    std::uint64_t frames = 0;           // by processing time
    std::uint64_t clock_samples = 0;    // by clock error
    static void fields(auto& self, auto&& f) {
      f("from_ms", self.from_ms, "to_ms", self.to_ms, "frames", self.frames, "clock_samples",
        self.clock_samples);
    }
  };
  std::string source;
  std::uint64_t frames = 0, clients = 0;
  std::vector<Row> rows;
  std::uint64_t lost_frames = 0;
  double real_time_percent = 0.0, below_2ms_percent = 0.0;  // of the text
  static void fields(auto& self, auto&& f) {
    f("source", self.source, "frames", self.frames, "clients", self.clients, "rows", self.rows, "lost_frames",
      self.lost_frames, "real_time_percent", self.real_time_percent, "below_2ms_percent",
      self.below_2ms_percent);
  }
};

PrintedTable4 printed_table4();

// The errata of the paper: what it prints, why that cannot be right, and what replaces it, in our words.
struct PrintedErrata {
  struct Erratum {
    std::string id, where, printed, problem, corrected;
    bool changes_results = true;  // false: of the text or of a printed table alone
    static void fields(auto& self, auto&& f) {
      f("id", self.id, "where", self.where, "printed", self.printed, "problem", self.problem, "corrected",
        self.corrected, "changes_results", self.changes_results);
    }
  };
  std::string source;
  std::vector<Erratum> errata;
  static void fields(auto& self, auto&& f) { f("source", self.source, "errata", self.errata); }
};

PrintedErrata printed_errata();

}  // namespace trilat
