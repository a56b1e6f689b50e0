// SPDX-License-Identifier: MIT
#include "pipeline/simulate/simulated_mocap.h"

#include "datasets/base/error.h"
#include "datasets/mocap/optitrack_csv_writer.h"
#include "datasets/synthetic/simulated_markers.h"
#include "pipeline/simulate/simulated_truth.h"

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

}  // namespace trilat
