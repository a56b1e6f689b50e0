// SPDX-License-Identifier: MIT
#include "pipeline/simulate/simulated_mocap.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/mocap/optitrack_csv_writer.h"
#include "datasets/synthetic/simulated_markers.h"

namespace trilat {

void write_simulated_mocap(const MocapSpec& mocap_spec, const SimulatedTakePlan& plan,
                           const std::filesystem::path& folder, const std::function<bool()>& stop_requested) {
  std::vector<std::string> markers, joints;
  for (Joint joint : plan.marker_joints)
    for (int m = 0; m < kMarkersPerJoint; ++m) markers.push_back(marker_name(joint, m));
  for (int j = 0; j < kJointCount; ++j) joints.emplace_back(name_of(static_cast<Joint>(j)));
  const double rate_hz = mocap_spec.rate_hz;
  const std::int64_t frames = mocap_frames(mocap_spec, plan.duration_s);
  OptitrackCsvWriter mocap(folder / "mocap.csv", simulated_mocap_header(plan.id + " simulated", rate_hz,
                                                                        frames, AssetType::marker, markers));
  OptitrackCsvWriter truth(folder / "truth.csv", simulated_mocap_header(plan.id + " true joints", rate_hz,
                                                                        frames, AssetType::marker, joints));
  MocapFrame seen, exact;
  seen.poses.resize(markers.size());
  exact.poses.resize(joints.size());
  for (std::int64_t f = 0; f < frames; ++f) {
    if (f % 256 == 0 && stop_requested && stop_requested()) throw Interrupted();
    const SkeletonPose pose = plan.motion(static_cast<double>(f) / rate_hz);
    seen.index = exact.index = f;
    for (std::size_t j = 0; j < joints.size(); ++j) exact.poses[j].position_m = pose.joint_in_world_m[j];
    std::size_t next = 0;
    for (Joint joint : plan.marker_joints)
      for (const Eigen::Vector3d& marker :
           simulate_markers(pose, joint, mocap_spec, plan.item, static_cast<std::uint64_t>(f)))
        seen.poses[next++].position_m = marker;
    mocap.write(seen);
    truth.write(exact);
  }
  mocap.finish();
  truth.finish();
}

JointMapping marker_mapping(const std::vector<Joint>& joints) {
  JointMapping mapping;
  for (Joint joint : joints) {
    JointMapping::Entry entry{joint, {}};
    for (int m = 0; m < kMarkersPerJoint; ++m) entry.assets.push_back(marker_name(joint, m));
    mapping.joints.push_back(std::move(entry));
  }
  return mapping;
}

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
