// SPDX-License-Identifier: MIT
#include "datasets/synthetic/simulated_sensor.h"

#include <cmath>

#include "datasets/base/philox.h"
#include "datasets/base/units.h"

namespace trilat {
namespace {

constexpr std::int64_t kTick_ns = 100;

RandomStream stream_of(const SimulatedItem& item, Purpose purpose, std::uint64_t sensor, std::uint64_t part,
                       std::uint64_t step) {
  return {item.seed, purpose, random_item(item.take, sensor, part, step)};
}

double exponential(const RandomStream& random, std::uint32_t index, double mean) {
  return -mean * std::log(random.uniform(index));
}

}  // namespace

bool is_in_view(const SimulatedSensor& sensor, const SensorSpec& spec,
                const Eigen::Vector3d& point_in_sensor_m) {
  if (point_in_sensor_m.z() < spec.nearest_m || point_in_sensor_m.z() > spec.farthest_m) return false;
  const auto pixel = project(sensor.intrinsics, point_in_sensor_m);
  return pixel && pixel->x() >= 0.0 && pixel->y() >= 0.0 && pixel->x() <= sensor.intrinsics.width_px - 1.0 &&
         pixel->y() <= sensor.intrinsics.height_px - 1.0;
}

SimulatedSensor draw_sensor(const SensorSpec& spec, const SimulatedItem& item, std::uint64_t index,
                            const SensorPose& pose) {
  SimulatedSensor sensor;
  sensor.index = index;
  sensor.pose = pose;
  // A unit's optics belong to the unit, not to the take.
  const RandomStream unit{item.seed, Purpose::sensor_clock, random_item(0, index, 1, 0)};
  sensor.intrinsics.fx_px += unit.uniform(0, -spec.focal_spread_px, spec.focal_spread_px);
  sensor.intrinsics.fy_px = sensor.intrinsics.fx_px;
  sensor.intrinsics.cx_px += unit.uniform(1, -spec.centre_spread_px, spec.centre_spread_px);
  sensor.intrinsics.cy_px += unit.uniform(2, -spec.centre_spread_px, spec.centre_spread_px);
  sensor.host_from_sensor = {{0}, kMotionStart, 0.0};
  sensor.agent_from_host = {kMotionStart, {kMotionStart.ns}, 0.0};
  if (!spec.free_running) return sensor;
  const RandomStream clock = stream_of(item, Purpose::sensor_clock, index, 0, 0);
  const double drift = spec.clock_drift_ppm * 1e-6;
  const SensorTime origin{static_cast<std::int64_t>(clock.uniform(0, 0.0, 1000.0) * 1e7) * kTick_ns};
  sensor.host_from_sensor = {origin, kMotionStart, clock.uniform(1, -drift, drift)};
  sensor.agent_from_host = {kMotionStart,
                            {kMotionStart.ns + duration_from_s(clock.uniform(2, -1000.0, 1000.0)).ns},
                            clock.uniform(3, -drift, drift)};
  sensor.first_exposure = origin + duration_from_s(clock.uniform(4) / spec.rate_hz);
  return sensor;
}

SensorDescription description_of(const SimulatedSensor& sensor, const SensorSpec& spec) {
  SensorDescription description;
  description.name = sensor.pose.name;
  description.serial = "simulated-" + sensor.pose.name;
  description.source = "simulated";
  description.intrinsics = sensor.intrinsics;
  description.tick_ns = kTick_ns;
  description.nominal_rate_hz = spec.rate_hz;
  description.latency_ns = duration_from_s(spec.latency_s).ns;
  return description;
}

namespace {

std::int64_t device_ticks_of(const SimulatedSensor& sensor, const SensorSpec& spec, std::uint64_t frame) {
  const Duration since = duration_from_s(static_cast<double>(frame) / spec.rate_hz);
  return (sensor.first_exposure + since).ns / kTick_ns;
}

}  // namespace

HostTime exposure_of(const SimulatedSensor& sensor, const SensorSpec& spec, std::uint64_t frame) {
  return sensor.host_from_sensor({device_ticks_of(sensor, spec, frame) * kTick_ns});
}

std::optional<BodyFrame> simulate_empty_frame(const SimulatedSensor& sensor, const SensorSpec& spec,
                                              const SimulatedItem& item, std::uint64_t frame) {
  if (stream_of(item, Purpose::sensor_drop, sensor.index, 0, frame).uniform(0) < spec.dropped_share)
    return std::nullopt;
  const HostTime exposure = exposure_of(sensor, spec, frame);
  const double delay_s =
      spec.latency_s +
      exponential(stream_of(item, Purpose::arrival_delay, sensor.index, 0, frame), 0, spec.arrival_jitter_s);
  BodyFrame result;
  result.stamp = {static_cast<std::int64_t>(frame), device_ticks_of(sensor, spec, frame),
                  sensor.agent_from_host(exposure + duration_from_s(delay_s)).ns};
  const auto height_m = static_cast<float>(sensor.pose.world_from_sensor.translation_m.y());
  const Eigen::Vector3d up_in_sensor =
      sensor.pose.world_from_sensor.rotation.conjugate() * Eigen::Vector3d::UnitY();
  result.floor_plane = {static_cast<float>(up_in_sensor.x()), static_cast<float>(up_in_sensor.y()),
                        static_cast<float>(up_in_sensor.z()), height_m};
  return result;
}

ClockExchange simulate_exchange(const SimulatedSensor& sensor, const SensorSpec& spec,
                                const SimulatedItem& item, std::uint64_t number) {
  constexpr double kWire_s = 0.0002, kAnswer_s = 0.00005;
  const RandomStream random = stream_of(item, Purpose::clock_exchange, sensor.index, 0, number);
  const HostTime sent = kMotionStart + duration_from_s(static_cast<double>(number) * spec.exchange_period_s);
  const HostTime received = sent + duration_from_s(kWire_s + exponential(random, 0, spec.exchange_jitter_s));
  const HostTime answered = received + duration_from_s(kAnswer_s);
  const HostTime back = answered + duration_from_s(kWire_s + exponential(random, 1, spec.exchange_jitter_s));
  return {sent.ns, sensor.agent_from_host(received).ns, sensor.agent_from_host(answered).ns, back.ns};
}

}  // namespace trilat
