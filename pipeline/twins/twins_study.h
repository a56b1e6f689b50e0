// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "datasets/synthetic/tracker/body_tracker_spec.h"
#include "pipeline/study/study.h"

namespace trilat {

// A study of kind "twins": simulated pairs of sensors at the angles, distances and activities of the recorded
// ones (datasets/synthetic/recorded_pairs.h), and how both disagree.
struct TwinsSpec {
  std::string name;
  std::uint64_t seed = 1;
  std::uint64_t participants = 16;
  BodyTrackerSpec body_tracker = default_body_tracker();
  Json body_tracker_json = Json::object();  // as the study says it
};

TwinsSpec parse_twins(const Json& json, const std::string& place);

// Every setting written out.
Json resolved_json(const TwinsSpec& spec);

// An item a pair: its takes are simulated, the sensors placed by the bodies of the last activity, as those of
// the recorded ones were, and distances between the joints of both measured.
Study twins_study(const TwinsSpec& spec);

}  // namespace trilat
