// SPDX-License-Identifier: MIT
#include "pipeline/cli/simulate_take.h"

#include <atomic>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/mocap/optitrack_csv_writer.h"
#include "datasets/synthetic/recorded_motion.h"
#include "datasets/synthetic/simulated_markers.h"
#include "pipeline/parallel.h"
#include "recorders/recorder.h"
#include "recorders/synthetic_source.h"

namespace trilat {
namespace {

std::int64_t mocap_frames(const MocapSpec& mocap, double duration_s) {
  return static_cast<std::int64_t>(duration_s * mocap.rate_hz) + 1;
}

MocapHeader mocap_header(const std::string& name, double rate_hz, std::int64_t frames,
                         const std::vector<std::string>& markers) {
  MocapHeader header;
  header.take_name = name;
  header.capture_rate_hz = rate_hz;
  header.export_rate_hz = rate_hz;
  header.capture_start_frame = 0;
  header.total_frames_in_take = frames;
  header.total_exported_frames = frames;
  for (std::size_t m = 0; m < markers.size(); ++m)
    header.assets.push_back(
        {AssetType::marker, markers[m], fmt::format("{:X}", 0xA000 + m), "", false, true});
  return header;
}

// The virtual OptiTrack's export, and beside it the same frames without noise, gaps and markers.
void write_mocap(const SimulationSpec& spec, const SimulatedTakePlan& plan,
                 const std::filesystem::path& folder, const std::function<bool()>& stop_requested) {
  std::vector<std::string> markers, joints;
  for (Joint joint : plan.marker_joints)
    for (int m = 0; m < kMarkersPerJoint; ++m) markers.push_back(marker_name(joint, m));
  for (int j = 0; j < kJointCount; ++j) joints.emplace_back(name_of(static_cast<Joint>(j)));
  const double rate_hz = spec.mocap.rate_hz;
  const std::int64_t frames = mocap_frames(spec.mocap, plan.duration_s);
  OptitrackCsvWriter mocap(folder / "mocap.csv",
                           mocap_header(plan.id + " simulated", rate_hz, frames, markers));
  OptitrackCsvWriter truth(folder / "truth.csv",
                           mocap_header(plan.id + " true joints", rate_hz, frames, joints));
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
           simulate_markers(pose, joint, spec.mocap, plan.item, static_cast<std::uint64_t>(f)))
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

void copy_recorded(const std::filesystem::path& from, const std::filesystem::path& to) {
  const std::filesystem::path partial = partial_name(to);
  std::error_code error;
  std::filesystem::copy_file(from, partial, std::filesystem::copy_options::overwrite_existing, error);
  if (error) throw InputError(to.string(), "cannot be copied from " + from.string() + ": " + error.message());
  std::filesystem::permissions(partial, std::filesystem::perms::owner_write,
                               std::filesystem::perm_options::add, error);
  publish_file(partial, to);
}

// What only the simulator knows.
void write_truth(const SimulatedTakePlan& plan, const std::vector<SimulatedSensor>& sensors,
                 Duration mocap_error, const std::filesystem::path& folder) {
  Json list = Json::array();
  for (const SimulatedSensor& s : sensors)
    list.push_back(
        {{"name", s.pose.name},
         {"sensor_clock_origin_ns", s.host_from_sensor.origin_from.ns},
         {"host_at_origin_ns", s.host_from_sensor.origin_to.ns},
         {"host_from_sensor_drift", s.host_from_sensor.drift},
         {"agent_minus_host_at_start_ns", s.agent_from_host.origin_to.ns - s.agent_from_host.origin_from.ns},
         {"agent_from_host_drift", s.agent_from_host.drift}});
  const Json json{{"format", "trilat.simulated_truth"},
                  {"version", 1},
                  {"motion_start_host_ns", kMotionStart.ns},
                  {"stated_minus_true_mocap_start_ns", mocap_error.ns},
                  {"seed", plan.item.seed},
                  {"sensors", list}};
  write_file(folder / "truth.json", json.dump(2) + "\n");
}

std::vector<SimulatedTakePlan> generated_takes(const SimulationSpec& spec) {
  std::vector<SimulatedTakePlan> takes;
  for (std::uint64_t p = 0; p < spec.participants; ++p) {
    const Person person = draw_person(spec.seed, p, spec.stature_mean_m, spec.stature_half_range_m);
    for (const ActivitySpec& activity : spec.activities) {
      SimulatedTakePlan take;
      take.participant = fmt::format("p{:02}", p + 1);
      take.activity = activity_names()[static_cast<std::size_t>(activity.activity)];
      take.id = take.participant + "-" + take.activity;
      for (const SimulatedTakePlan& other : takes)
        if (other.id == take.id) take.id += fmt::format("-{}", takes.size() + 1);
      take.item = {spec.seed, takes.size(), p};
      take.motion = generated_motion(person, activity.activity);
      take.duration_s = activity.duration_s;
      take.marker_joints = activity.marker_joints;
      takes.push_back(std::move(take));
    }
  }
  return takes;
}

SimulatedTakePlan recorded_take(const SimulationSpec& spec, const RecordedMotion& recorded) {
  SimulatedTakePlan take;
  take.id = "take";
  take.participant = "recorded";
  take.activity = "recorded";
  take.item = {spec.seed, 0, 0};
  take.motion = recorded.motion;
  take.duration_s = recorded.duration_s;
  take.recorded_mocap = spec.recorded->mocap;
  take.recorded_mapping = spec.recorded->mapping;
  return take;
}

}  // namespace

Take simulate_take(const SimulationSpec& spec, const SimulatedTakePlan& plan,
                   const std::vector<SensorPose>& poses, const std::filesystem::path& folder,
                   const std::filesystem::path& calibration, const std::function<bool()>& stop_requested) {
  make_folder(folder);
  std::vector<SimulatedSensor> sensors;
  for (std::size_t s = 0; s < poses.size(); ++s)
    sensors.push_back(draw_sensor(spec.sensor, plan.item, s, poses[s]));
  SyntheticSource source(spec.sensor, plan.item, plan.motion, sensors, plan.duration_s);
  RecordOptions options;
  options.stop_requested = stop_requested;
  record(source, folder / "session.h5", options);
  if (plan.recorded_mocap.empty()) {
    write_mocap(spec, plan, folder, stop_requested);
    write_mapping(folder / "mapping.json", marker_mapping(plan.marker_joints));
  } else {
    copy_recorded(plan.recorded_mocap, folder / "mocap.csv");
    copy_recorded(plan.recorded_mapping, folder / "mapping.json");
  }
  const Duration error = mocap_clock_error(spec.mocap, plan.item);
  write_truth(plan, sensors, error, folder);
  return {plan.id,     plan.participant,     plan.activity,           folder / "session.h5",
          calibration, folder / "mocap.csv", folder / "mapping.json", (kMotionStart + error).ns};
}

Campaign simulate_campaign(const SimulationSpec& spec, const std::filesystem::path& folder,
                           const std::function<bool()>& stop_requested,
                           const std::function<void(double)>& progress) {
  std::vector<SimulatedTakePlan> takes;
  Eigen::Vector3d centre_m(0.0, 1.0, 0.0);
  if (spec.recorded) {
    const RecordedMotion recorded = read_recorded_motion(spec.recorded->mocap, spec.recorded->mapping);
    centre_m = recorded.centre_m;
    takes.push_back(recorded_take(spec, recorded));
  } else {
    takes = generated_takes(spec);
  }
  make_folder(folder);
  std::filesystem::remove(folder / "campaign.json");  // says that all takes are there
  const std::vector<SensorPose> poses = rig_poses(spec.rig, centre_m);
  write_calibration(folder / "calibration.json", {"simulated truth", poses});
  Campaign campaign{spec.name, true, {}, folder};
  campaign.takes.resize(takes.size());
  std::atomic<std::size_t> done{0};
  parallel_for_index(takes.size(), 1, [&](std::size_t t) {
    if (stop_requested && stop_requested()) throw Interrupted();
    campaign.takes[t] = simulate_take(spec, takes[t], poses, folder / takes[t].id,
                                      folder / "calibration.json", stop_requested);
    if (progress) progress(static_cast<double>(++done) / static_cast<double>(takes.size()));
  });
  write_campaign(folder, campaign);
  return campaign;
}

}  // namespace trilat
