// SPDX-License-Identifier: MIT
#include "pipeline/claims/measures.h"

#include <array>

namespace trilat {
namespace {

// The audit of the paper has the numbers that contradict each other.
MeasuredPart measure_printed(JsonObject& part, const ClaimStudies&) {
  part.text("erratum");
  return {.contradicts = true};
}

MeasuredPart measure_nothing(JsonObject& part, const ClaimStudies&) { return missing(part.text("because")); }

struct Statistic {
  const char* name;
  MeasuredPart (*measure)(JsonObject&, const ClaimStudies&);
};
constexpr std::array kStatistics{Statistic{"errors", measure_errors},
                                 Statistic{"places", measure_places},
                                 Statistic{"speed", measure_speed},
                                 Statistic{"clock_cost", measure_clock_cost},
                                 Statistic{"clock_share", measure_clock_share},
                                 Statistic{"queue", measure_queue},
                                 Statistic{"wand", measure_wand},
                                 Statistic{"image_edges", measure_image_edges},
                                 Statistic{"readings", measure_readings},
                                 Statistic{"printed", measure_printed},
                                 Statistic{"none", measure_nothing}};

}  // namespace

ClaimStudies::ClaimStudies(const PaperEvidence& of) : evidence(of) {
  if (of.walking) walking.emplace_back(*of.walking);
  if (of.occluded) occluded.emplace_back(*of.occluded);
  for (const ResultsSummary& study : of.sensor_counts) sensor_counts.emplace_back(study);
}

MeasuredPart measure(JsonObject& part, const ClaimStudies& studies) {
  std::vector<std::string> names;
  for (const Statistic& statistic : kStatistics) names.emplace_back(statistic.name);
  return kStatistics.at(part.choice("statistic", names)).measure(part, studies);
}

}  // namespace trilat
