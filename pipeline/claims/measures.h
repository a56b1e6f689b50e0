// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/results/paper_evidence.h"
#include "evaluators/metrics/cluster_ratios.h"
#include "pipeline/accuracy/errors/participant_errors.h"

namespace trilat {

// One number, in its unit, "%" or "cm".
struct Measurement {
  std::string what;  // "linear against nonlinear, head"
  std::string unit;
  ContrastEstimate estimate;
  std::optional<ContrastEstimate> complete = {};  // the same over what any of the two methods answers
};

// What one entry of a claim's "parts" comes to in the results.
struct MeasuredPart {
  std::vector<Measurement> parts = {};    // one, or one for each study of its kind and joint group
  std::string missing = {};               // what there would have to be; then there are no parts
  bool contradicts = false;               // the paper's numbers contradict each other
  std::string clusters = "participants";  // what intervals are over
};

// The results that parts are measured in, with the errors of the accuracy studies by participant. Keeps a
// reference to the evidence.
struct ClaimStudies {
  explicit ClaimStudies(const PaperEvidence& of);
  const PaperEvidence& evidence;
  std::vector<ParticipantErrors> walking, occluded;  // none or one
  std::vector<ParticipantErrors> sensor_counts;
};

// By the entry's "statistic". InputError with its place when it is none that is known, or has not what its
// statistic needs.
MeasuredPart measure(JsonObject& part, const ClaimStudies& studies);

// The statistics that claims.json names, but those of statistics.cpp itself.
MeasuredPart measure_errors(JsonObject& part, const ClaimStudies& e);
MeasuredPart measure_places(JsonObject& part, const ClaimStudies& e);
MeasuredPart measure_speed(JsonObject& part, const ClaimStudies& e);
MeasuredPart measure_clock_cost(JsonObject& part, const ClaimStudies& e);
MeasuredPart measure_readings(JsonObject& part, const ClaimStudies& e);
MeasuredPart measure_clock_share(JsonObject& part, const ClaimStudies& e);
MeasuredPart measure_queue(JsonObject& part, const ClaimStudies& e);
MeasuredPart measure_wand(JsonObject& part, const ClaimStudies& e);
MeasuredPart measure_image_edges(JsonObject& part, const ClaimStudies& e);

inline MeasuredPart missing(const std::string& what) { return {.missing = what}; }

inline ContrastEstimate scaled(ContrastEstimate e, double factor) {
  e.value *= factor;
  e.standard_error *= factor;
  return e;
}

inline ContrastEstimate percent_of(const Contrast& contrast) {
  return scaled(solve_contrast(contrast), 100.0);
}

}  // namespace trilat
