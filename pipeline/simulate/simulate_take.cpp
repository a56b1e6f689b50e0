// SPDX-License-Identifier: MIT
#include "pipeline/simulate/simulate_take.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/mocap/mocap_writer.h"
#include "datasets/synthetic/generated_person.h"
#include "datasets/synthetic/motion.h"
#include "datasets/synthetic/simulated_markers.h"
#include "datasets/synthetic/simulation_spec.h"
#include "recorders/capture.h"
#include "recorders/synthetic_source.h"

namespace trilat {
namespace {

void copy_recorded(const std::filesystem::path& from, const std::filesystem::path& to) {
  const std::filesystem::path partial = partial_name(to);
  std::error_code error;
  std::filesystem::copy_file(from, partial, std::filesystem::copy_options::overwrite_existing, error);
  if (error) throw InputError(to.string(), "cannot be copied from " + from.string() + ": " + error.message());
  std::filesystem::permissions(partial, std::filesystem::perms::owner_write,
                               std::filesystem::perm_options::add, error);
  publish_file(partial, to);
}

// The person in the room as the sensors see them at one time of the take.
SceneMotion scene_of(const SimulationSpec& spec, const SimulatedTakePlan& plan,
                     const Eigen::Vector3d& rig_centre_m) {
  return [&spec, &plan, rig_centre_m](double time_s) {
    DepthScene scene;
    append_room(scene, spec.room, rig_centre_m);
    append_person(scene, plan.motion(time_s));
    return scene;
  };
}

std::vector<SimulatedTakePlan> generated_takes(const SimulationSpec& spec) {
  std::vector<SimulatedTakePlan> takes;
  for (std::uint64_t p = 0; p < spec.participants; ++p) {
    const Person person = draw_person(spec.seed, p, spec.stature.mean_m, spec.stature.half_range_m);
    for (const ActivitySpec& activity : spec.activities) {
      SimulatedTakePlan take;
      take.participant = fmt::format("p{:02}", p + 1);
      take.activity = word_of(activity.activity);
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
  take.activity = spec.recorded->activity;
  take.item = {spec.seed, 0, 0};
  take.motion = recorded.motion;
  take.duration_s = recorded.duration_s;
  take.recorded_mocap = spec.recorded->mocap;
  take.recorded_mapping = spec.recorded->mapping;
  take.up_axis = spec.recorded->up_axis.value_or(UpAxis::y);
  return take;
}

void record_take(const SimulationSpec& spec, const SimulatedTakePlan& plan, const SimulatedRig& rig,
                 const std::vector<SimulatedSensor>& sensors, const std::filesystem::path& session,
                 const RunControl& control) {
  RecordOptions options;
  options.stop_requested = control.stop_requested;
  std::optional<SyntheticDepth> depth;
  if (spec.depth.takes)
    depth = watched_depth(spec, sensors.size(), plan.duration_s, scene_of(spec, plan, rig.centre_m), control);
  SyntheticSource source(spec.sensor, plan.item, plan.motion, sensors, plan.duration_s, spec.body_tracker,
                         std::move(depth));
  record(source, session, options);
}

}  // namespace

Take simulate_take(const SimulationSpec& spec, const SimulatedTakePlan& plan, const SimulatedRig& rig,
                   const std::filesystem::path& folder, const RunControl& control) {
  make_folder(folder);
  std::vector<SimulatedSensor> sensors;
  for (const SensorPose& pose : rig.poses) {
    sensors.push_back(draw_sensor(spec.sensor, plan.item, sensors.size(), pose));
    sensors.back().unit = draw_depth_unit(spec.depth.noise, plan.item.seed, sensors.back().index);
  }
  record_take(spec, plan, rig, sensors, folder / "session.h5", control);
  if (plan.recorded_mocap.empty()) {
    write_simulated_mocap(spec.mocap, plan, folder, control.stop_requested);
    write_mapping(folder / "mapping.json", marker_mapping(plan.marker_joints));
  } else {
    copy_recorded(plan.recorded_mocap, folder / "mocap.csv");
    copy_recorded(plan.recorded_mapping, folder / "mapping.json");
  }
  const Duration error = mocap_clock_error(spec.mocap, plan.item);
  const Json truth =
      simulated_truth(plan.item, sensors, error, spec.depth.takes ? &spec.depth.noise : nullptr);
  write_file(folder / "truth.json", truth.dump(2) + "\n");
  return {plan.id,     plan.participant,     plan.activity,           folder / "session.h5",
          {},          folder / "mocap.csv", folder / "mapping.json", (kMotionStart + error).ns,
          plan.up_axis};
}

SimulatedCampaign simulated_campaign(const SimulationSpec& spec) {
  SimulatedCampaign campaign;
  Eigen::Vector3d centre_m(0.0, 1.0, 0.0);
  if (spec.recorded) {
    const RecordedMotion recorded =
        read_recorded_motion(spec.recorded->mocap, spec.recorded->mapping, spec.recorded->up_axis);
    centre_m = recorded.centre_m;
    campaign.takes.push_back(recorded_take(spec, recorded));
  } else {
    campaign.takes = generated_takes(spec);
  }
  campaign.rig = {rig_poses(spec.rig, centre_m), spec.rig.centre_m.value_or(centre_m)};
  campaign.calibration = calibration_recordings(spec, campaign.rig.poses, campaign.rig.centre_m);
  return campaign;
}

std::vector<double> costs_of(const SimulationSpec& spec, const SimulatedCampaign& campaign) {
  constexpr double kDepth = 60.0;
  std::vector<double> costs;
  for (const SimulatedTakePlan& take : campaign.takes)
    costs.push_back(take.duration_s * (spec.depth.takes ? kDepth : 1.0));
  for (const CalibrationRecording& recording : campaign.calibration)
    costs.push_back(kDepth * recording.duration_s);
  return costs;
}

std::optional<Take> simulate_recording(const SimulationSpec& spec, const SimulatedCampaign& campaign,
                                       std::size_t recording, const std::filesystem::path& folder,
                                       const RunControl& control) {
  if (recording < campaign.takes.size())
    return simulate_take(spec, campaign.takes[recording], campaign.rig, folder, control);
  campaign.calibration[recording - campaign.takes.size()].simulate(folder, control);
  return std::nullopt;
}

void write_rig(const SimulationSpec& spec, const SimulatedRig& rig, const std::filesystem::path& folder) {
  write_simulation_assumptions(folder, simulation_parameters(spec));  // first: by it a simulation is known
  Calibration calibration{kSimulatedTruth, rig.poses};
  if (spec.rig.position_sigma_m > 0.0 || spec.rig.rotation_sigma_rad > 0.0)
    calibration = perturbed(calibration, spec.rig.position_sigma_m, spec.rig.rotation_sigma_rad, spec.seed);
  calibration.simulated = true;
  write_calibration(folder / "calibration.json", calibration);
}

void write_simulated_mocap(const MocapSpec& mocap_spec, const SimulatedTakePlan& plan,
                           const std::filesystem::path& folder, const std::function<bool()>& stop_requested) {
  std::vector<std::string> markers, joints;
  for (Joint joint : plan.marker_joints)
    for (int m = 0; m < kMarkersPerJoint; ++m) markers.push_back(marker_name(joint, m));
  for (int j = 0; j < kJointCount; ++j) joints.emplace_back(name_of(static_cast<Joint>(j)));
  const double rate_hz = mocap_spec.rate_hz;
  const std::int64_t frames = mocap_frames(mocap_spec, plan.duration_s);
  const auto writer = [&](const char* file, const std::string& what, const std::vector<std::string>& names) {
    const std::string take = plan.id + what + std::string(kSimulatedTake);
    return OptitrackCsvWriter(folder / file,
                              simulated_mocap_header(take, rate_hz, frames, AssetType::marker, names));
  };
  OptitrackCsvWriter mocap = writer("mocap.csv", "", markers),
                     truth = writer("truth.csv", " true joints", joints);
  std::vector<Eigen::Vector3d> seen(markers.size());
  for (std::int64_t f = 0; f < frames; ++f) {
    if (f % 256 == 0 && stop_requested && stop_requested()) throw Interrupted();
    const SkeletonPose pose = plan.motion(static_cast<double>(f) / rate_hz);
    std::size_t next = 0;
    for (Joint joint : plan.marker_joints)
      for (const Eigen::Vector3d& marker :
           simulate_markers(pose, joint, mocap_spec, plan.item, static_cast<std::uint64_t>(f)))
        seen[next++] = marker;
    mocap.write(f, seen);
    truth.write(f, pose.joint_in_world_m);
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
    header.assets.push_back({type, assets[a], fmt::format("{:X}", 0xA000 + a), "", true});
  return header;
}

std::int64_t mocap_frames(const MocapSpec& mocap, double duration_s) {
  return static_cast<std::int64_t>(duration_s * mocap.rate_hz) + 1;
}

}  // namespace trilat
