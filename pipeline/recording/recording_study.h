// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/results/declared_parameters.h"
#include "pipeline/accuracy/methods/method_spec.h"
#include "pipeline/study/study.h"

namespace trilat {

// How messages travel between the server and a sensor's machine. Delays of a message: `wire_s` plus an
// exponential part.
struct NetworkSpec {
  std::string name = "local network";
  double wire_s = 0.0002;
  double asymmetry_s = 0.0;             // more on the way to the sensor's machine
  double jitter_s = 0.0005;             // mean of the exponential part
  std::optional<double> jitter_back_s;  // of messages to the server, where they differ
  double lost_share = 0.01;             // of exchanges
  bool operator==(const NetworkSpec&) const = default;
};

// A study of kind "recording": how well clocks are brought together, and what a frame costs, on simulated
// recordings in virtual time.
struct RecordingSpec {
  std::string name;
  std::uint64_t seed = 1;
  std::uint64_t frames = 18'000;  // as in the paper: 600 s at 30 Hz
  double rate_hz = 30.0;
  std::uint64_t sensors = 4;
  std::uint64_t runs = 10;        // each with other clocks
  double clock_offset_s = 0.05;   // uniform in +-, of a machine's clock at the start
  double clock_drift_ppm = 30.0;  // uniform in +-, of a machine and of a sensor
  double exchange_period_s = 0.25;
  double latency_s = 0.02;          // exposure to arrival, known
  double arrival_jitter_s = 0.001;  // mean of the exponential part
  std::vector<NetworkSpec> networks{NetworkSpec{}};
  // The most by which a frame's time of sending may differ from the server's time for the paper's queue.
  double late_s = 1.0 / 30.0;
  double body_tracking_s = 0.005;         // of a depth image on the sensor's machine
  double body_tracking_jitter_s = 0.001;  // mean of the exponential part
  // Frames are also trilaterated and timed, by each of these.
  std::vector<MethodSpec> methods;
};

RecordingSpec parse_recording_spec(const Json& json, const std::string& place);

// Every setting written out, defaults included.
Json resolved_json(RecordingSpec spec);

// Assumptions of the simulation, with sources.
std::vector<DeclaredParameter> recording_parameters(const RecordingSpec& spec);

// Simulated clocks and queues of a recording, and what a frame costs on this machine. Its summary.json is a
// RecordingSummary.
Study recording_study(const RecordingSpec& spec);

}  // namespace trilat
