// SPDX-License-Identifier: MIT
#include "pipeline/simulate/simulated_truth.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace trilat {

Json simulated_truth(const SimulatedItem& item, const std::vector<SimulatedSensor>& sensors,
                     Duration mocap_error, const DepthNoiseSpec* depth) {
  Json list = Json::array();
  for (const SimulatedSensor& s : sensors) {
    list.push_back(
        {{"name", s.pose.name},
         {"sensor_clock_origin_ns", s.host_from_sensor.origin_from.ns},
         {"host_at_origin_ns", s.host_from_sensor.origin_to.ns},
         {"host_from_sensor_drift", s.host_from_sensor.drift},
         {"agent_minus_host_at_start_ns", s.agent_from_host.origin_to.ns - s.agent_from_host.origin_from.ns},
         {"agent_from_host_drift", s.agent_from_host.drift}});
    if (!depth) continue;
    const DepthUnit unit = draw_depth_unit(*depth, item.seed, s.index);
    list.back()["depth_offset_m"] = unit.offset_m;
    list.back()["depth_wiggle_amplitude_m"] = unit.wiggle_amplitude_m;
    list.back()["depth_wiggle_length_m"] = unit.wiggle_length_m;
    list.back()["depth_wiggle_phase_rad"] = unit.wiggle_phase_rad;
  }
  return {{"format", "trilat.simulated_truth"},
          {"version", 1},
          {"motion_start_host_ns", kMotionStart.ns},
          {"stated_minus_true_mocap_start_ns", mocap_error.ns},
          {"seed", item.seed},
          {"sensors", list}};
}

MocapHeader simulated_mocap_header(const std::string& take_name, double rate_hz, std::int64_t frames,
                                   AssetType type, const std::vector<std::string>& assets) {
  MocapHeader header;
  header.take_name = take_name;
  header.capture_rate_hz = rate_hz;
  header.export_rate_hz = rate_hz;
  header.capture_start_frame = 0;
  header.total_frames_in_take = frames;
  header.total_exported_frames = frames;
  for (std::size_t a = 0; a < assets.size(); ++a)
    header.assets.push_back(
        {type, assets[a], fmt::format("{:X}", 0xA000 + a), "", type == AssetType::rigid_body, true});
  return header;
}

std::int64_t mocap_frames(const MocapSpec& mocap, double duration_s) {
  return static_cast<std::int64_t>(duration_s * mocap.rate_hz) + 1;
}

}  // namespace trilat
