// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/claims/statistics.h"

namespace trilat {

// The statistics that claims.json names, but those of statistics.cpp itself.
MeasuredPart measure_errors(JsonObject& part, const ClaimStudies& e);
MeasuredPart measure_places(JsonObject& part, const ClaimStudies& e);
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
