// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/results/paper_evidence.h"
#include "evaluators/metrics/cluster_contrast.h"
#include "pipeline/accuracy/participant_errors.h"

namespace trilat {

// One number, in its unit, "%" or "cm".
struct Measurement {
  std::string what;  // "linear against nonlinear, head"
  std::string unit;
  ContrastEstimate estimate;
  std::optional<ContrastEstimate> complete = {};  // the same with fallbacks where a method has no answer
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

}  // namespace trilat
