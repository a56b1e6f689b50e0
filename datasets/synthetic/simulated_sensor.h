// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "datasets/base/time.h"
#include "datasets/session/clock/agent_clock.h"
#include "datasets/session/session_types.h"
#include "datasets/synthetic/depth/depth_renderer.h"
#include "datasets/synthetic/motion.h"
#include "datasets/synthetic/simulation_spec.h"

namespace trilat {

// Place of a simulated recording in the campaign: the keys of its random numbers.
struct SimulatedItem {
  std::uint64_t seed = 1;
  std::uint64_t take = 0;
  std::uint64_t participant = 0;
};

// One virtual Kinect in one take, with what only the simulator knows: its true pose and clocks.
struct SimulatedSensor {
  std::uint64_t index = 0;
  SensorPose pose;
  DepthIntrinsics intrinsics;
  ClockMap<HostClock, SensorClock> host_from_sensor;
  ClockMap<AgentTag, HostClock> agent_from_host;
  SensorTime first_exposure;
  DepthUnit unit = {};
};

// The motion starts at this reading of the recording's host clock in every simulated take.
inline constexpr HostTime kMotionStart{1'000'000'000'000};

SimulatedSensor draw_sensor(const SensorSpec& spec, const SimulatedItem& item, std::uint64_t index,
                            const SensorPose& pose);
SensorDescription description_of(const SimulatedSensor& sensor, const SensorSpec& spec);

// Exposure of frame number `frame` on the true host clock.
HostTime exposure_of(const SimulatedSensor& sensor, const SensorSpec& spec, std::uint64_t frame);

// Whether a point lies in the sensor's image and range.
bool is_in_view(const SimulatedSensor& sensor, const SensorSpec& spec,
                const Eigen::Vector3d& point_in_sensor_m);

// A frame with stamps and floor but without bodies, or nothing when it was dropped.
std::optional<BodyFrame> simulate_empty_frame(const SimulatedSensor& sensor, const SensorSpec& spec,
                                              const SimulatedItem& item, std::uint64_t frame);

// Exchange number `number`; one every spec.exchange_period_s from the start of the motion.
ClockExchange simulate_exchange(const SimulatedSensor& sensor, const SensorSpec& spec,
                                const SimulatedItem& item, std::uint64_t number);

}  // namespace trilat
