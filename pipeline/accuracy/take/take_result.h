// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/results/summary.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/tracking_summary.h"

namespace trilat {

// A file that a take is made of.
struct TakeInput {
  std::string role, file;  // what it is, its name
  std::uintmax_t bytes = 0;
  std::string sha256;  // empty when it could not be read

  static void fields(auto& self, auto&& f) {
    f("role", self.role, "file", self.file, "bytes", self.bytes, "sha256", self.sha256);
  }
};

// How far one of the own solvers and Ceres were apart in one take.
struct TakeCheck {
  std::uint64_t samples = 0, disagreements = 0, lost = 0;  // lost: Ceres' objective is lower
  double worst_m = 0.0;
  std::string worst_at, disagreed_at;  // the first
  void merge(const TakeCheck& later);

  static void fields(auto& self, auto&& f) {
    f("samples", self.samples, "disagreements", self.disagreements, "lost", self.lost, "worst_m",
      self.worst_m, "worst_at", self.worst_at, "disagreed_at", self.disagreed_at);
  }
};

// Diagnostics of one take's sensors.
struct TakeTracking {
  std::vector<CheckRow> checks;
  ClockOffsetRow clock;
  RayNoiseRow rays = {};
  std::vector<RuleRow> rules = {};
  std::vector<BoundRow> bounds = {};

  static void fields(auto& self, auto&& f) {
    f("checks", self.checks, "clock", self.clock, "rays", self.rays, "rules", self.rules, "bounds",
      self.bounds);
  }
};

// All that evaluating one take gives besides its file.
struct TakeResult {
  std::vector<TakeInput> inputs;
  std::vector<TakeNote> notes;    // places are given from the campaign's folder
  std::vector<TakeCheck> checks;  // by checked method; empty when the cross-check was not asked for
  TakeTracking tracking;
  bool evaluated = false;

  static void fields(auto& self, auto&& f) {
    f("evaluated", self.evaluated, "inputs", self.inputs, "notes", self.notes, "checks", self.checks,
      "tracking", self.tracking);
  }
};

// The results of all takes of a plan together.
struct StudyTotals {
  std::vector<TakeNote> notes;  // in the order of the takes
  std::vector<bool> evaluated;  // by take
  std::vector<CrossCheck> cross_checks;
  TrackingSummary tracking;
};
StudyTotals outcome_of(const Plan& plan, std::span<const TakeResult> takes, bool cross_check);

}  // namespace trilat
