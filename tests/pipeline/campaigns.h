// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/accuracy/methods/study_spec.h"
#include "pipeline/simulate/campaign_study.h"

namespace trilat {

// Persons who walk for a second. Each sensor's tracker has a bias and white noise of its own and is else
// exact.
inline SimulationSpec walking_spec(std::uint64_t participants, double duration_s = 1.0) {
  SimulationSpec spec;
  spec.name = "tiny";
  spec.seed = 5;
  spec.participants = participants;
  spec.body_tracker = exact_body_tracker();
  spec.body_tracker.own_bias_sigma_m.fill(0.03);
  spec.body_tracker.jitter_sigma_m.fill(0.015);
  spec.activities = {{Activity::walking,
                      duration_s,
                      {Joint::head, Joint::shoulder_left, Joint::shoulder_right, Joint::elbow_left,
                       Joint::elbow_right, Joint::wrist_left, Joint::wrist_right}}};
  return spec;
}

// The same with sensors and mocap that are exact; clocks are as before.
inline SimulationSpec without_noise(SimulationSpec spec) {
  spec.body_tracker = exact_body_tracker();
  spec.sensor.dropped_share = 0.0;
  spec.mocap.marker_noise_sigma_m = 0.0;
  spec.mocap.gap_share = 0.0;
  return spec;
}

// The same with all clocks equal and a mocap that has a frame at every frame of the sensors.
inline SimulationSpec synchronised(SimulationSpec spec) {
  spec.sensor.free_running = false;
  spec.sensor.arrival_jitter_s = 0.0;
  spec.mocap.clock_error_s = 0.0;
  spec.mocap.rate_hz = 300.0;
  return spec;
}

inline Campaign simulate_into(const std::filesystem::path& folder, const SimulationSpec& spec) {
  return simulate_campaign(spec, folder, {});
}

// Recording of another person, who walks about a place that is 1.4 m from the first one's.
inline std::filesystem::path simulate_other_person(const std::filesystem::path& folder, SimulationSpec spec) {
  spec.seed += 1;
  spec.participants = 1;
  spec.rig.centre_m = Eigen::Vector3d(1.3, 1.0, 0.5);
  return simulate_into(folder, spec).takes.at(0).session;
}

inline StudySpec study_of(const std::string& members) {
  const std::string text =
      R"({"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "test", )" + members + "}";
  return parse_study(parse_json(text, "study.json"), "study.json", {});
}

}  // namespace trilat
