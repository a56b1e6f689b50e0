// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_work.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"

namespace trilat {
namespace {

const std::vector<std::string> kMethods{"wand", "two_positions", "printed"};

constexpr std::pair<const char*, double DepthIntrinsics::*> kIntrinsics[] = {
    {"fx_px", &DepthIntrinsics::fx_px}, {"fy_px", &DepthIntrinsics::fy_px},
    {"cx_px", &DepthIntrinsics::cx_px}, {"cy_px", &DepthIntrinsics::cy_px},
    {"k1", &DepthIntrinsics::k1},       {"k2", &DepthIntrinsics::k2},
    {"k3", &DepthIntrinsics::k3},       {"p1", &DepthIntrinsics::p1},
    {"p2", &DepthIntrinsics::p2}};

Json json_of(const RecordedSensor& sensor) {
  Json json{
      {"name", sensor.name}, {"depth_frames", sensor.frames}, {"intrinsics", json_of(sensor.intrinsics)}};
  if (sensor.floor) {
    const Eigen::Vector3d& up = sensor.floor->up_in_sensor;
    json["floor_plane"] = {up.x(), up.y(), up.z(), sensor.floor->height_m};
  }
  return json;
}

RecordedSensor read_sensor(JsonObject& object) {
  RecordedSensor sensor{object.text("name"), object.count("depth_frames"), {}};
  JsonObject intrinsics = object.object("intrinsics");
  for (const auto& [name, member] : kIntrinsics) sensor.intrinsics.*member = intrinsics.number(name);
  intrinsics.finish();
  if (object.has("floor_plane")) {
    const std::vector<double> plane = object.numbers("floor_plane", 4);
    sensor.floor = FloorPlane{{plane[0], plane[1], plane[2]}, plane[3]};
  }
  object.finish();
  return sensor;
}

Json json_of(const CalibrateWandOptions& options) {
  Json json{{"ball_radius_m", options.search.find.ball_radius_m},
            {"depth_correction", options.depth_correction},
            {"movement_sigma_m", options.movement_sigma_m}};
  if (options.movement_m) json["movement_m"] = *options.movement_m;
  if (options.trajectory_axis)
    json["trajectory_axis"] = kTrajectoryAxes.at(static_cast<std::size_t>(*options.trajectory_axis));
  if (options.world)
    json["mocap"] = {{"file", options.world->mocap.filename().string()},
                     {"asset", options.world->asset},
                     {"start_host_ns", options.world->mocap_start_host_ns}};
  return json;
}

CalibrateWandOptions read_options(JsonObject object) {
  CalibrateWandOptions options;
  options.search.find.ball_radius_m = object.positive("ball_radius_m");
  options.depth_correction = object.boolean("depth_correction", true);
  options.movement_sigma_m = object.positive("movement_sigma_m");
  if (object.has("movement_m")) options.movement_m = object.positive("movement_m");
  if (object.has("trajectory_axis"))
    options.trajectory_axis = static_cast<TrajectoryAxis>(object.choice("trajectory_axis", kTrajectoryAxes));
  if (object.has("mocap")) {
    JsonObject mocap = object.object("mocap");
    options.world = WandInWorld{mocap.text("file"), mocap.text("asset"), mocap.integer("start_host_ns")};
    mocap.finish();
  }
  object.finish();
  return options;
}

// Besides the recordings.
std::vector<std::filesystem::path> other_files(const CalibrateWandOptions& options) {
  std::vector<std::filesystem::path> files;
  if (options.world) files.push_back(options.world->mocap);
  for (const auto& [name, file] : options.intrinsics) files.push_back(file);
  return files;
}

}  // namespace

std::string name_of(WandMethod method) { return kMethods.at(static_cast<std::size_t>(method)); }

std::vector<SessionReader> open_sessions(const std::vector<std::filesystem::path>& files) {
  return {files.begin(), files.end()};
}

WatchedFiles watched_files(const std::vector<std::filesystem::path>& recordings,
                           const CalibrateWandOptions& options) {
  WatchedFiles watched(recordings);
  for (const std::filesystem::path& file : other_files(options)) watched.add(file);
  return watched;
}

WandWork make_wand_work(std::span<const SessionReader> sessions, WandMethod method,
                        const CalibrateWandOptions& options) {
  WandWork work{
      .method = method,
      .options = options,
      .recordings = read_wand_recordings(sessions, options.intrinsics, method == WandMethod::two_positions)};
  for (const std::filesystem::path& file : other_files(options))
    work.other_sources.push_back(
        {file.filename().string(), hash_of_file(file, options.search.watch.stop_requested)});
  return work;
}

std::vector<CalibrationSource> sources_of(const WandWork& work) {
  std::vector<CalibrationSource> sources;
  for (const WandRecording& recording : work.recordings)
    sources.push_back({std::filesystem::path(recording.place).filename().string(), recording.sha256});
  sources.insert(sources.end(), work.other_sources.begin(), work.other_sources.end());
  return sources;
}

Json json_of(const DepthIntrinsics& intrinsics) {
  Json json = Json::object();
  for (const auto& [name, member] : kIntrinsics) json[name] = intrinsics.*member;
  return json;
}

Json json_of(const WandWork& work) {
  Json sources = Json::array(), recordings = Json::array();
  for (const CalibrationSource& source : work.other_sources)
    sources.push_back({{"file", source.file}, {"sha256", source.sha256}});
  for (const WandRecording& recording : work.recordings) {
    Json sensors = Json::array();
    for (const RecordedSensor& sensor : recording.sensors) sensors.push_back(json_of(sensor));
    recordings.push_back({{"file", std::filesystem::path(recording.place).filename().string()},
                          {"bytes", recording.bytes},
                          {"fingerprint", recording.fingerprint},
                          {"simulated", recording.simulated},
                          {"sensors", sensors}});
  }
  return {{"method", name_of(work.method)},
          {"recordings", recordings},
          {"other_sources", sources},
          {"options", json_of(work.options)},
          {"frames_of_item", work.frames_of_item}};
}

WandWork read_wand_work(const Json& json, const std::string& place) {
  JsonObject object(json, place, "/work");
  WandWork work;
  work.method = static_cast<WandMethod>(object.choice("method", kMethods));
  for (JsonObject& source : object.objects("other_sources")) {
    work.other_sources.push_back({source.text("file"), source.text("sha256")});
    source.finish();
  }
  work.options = read_options(object.object("options"));
  work.frames_of_item = object.count("frames_of_item");
  if (work.frames_of_item == 0 || work.frames_of_item % kWandBlock != 0)
    object.refuse("frames_of_item", fmt::format("must be a multiple of {}", kWandBlock));
  for (JsonObject& entry : object.objects("recordings")) {
    WandRecording recording{.place = entry.text("file"), .bytes = entry.count("bytes")};
    recording.fingerprint = entry.text("fingerprint");
    recording.simulated = entry.boolean("simulated", false);
    for (JsonObject& sensor : entry.objects("sensors")) recording.sensors.push_back(read_sensor(sensor));
    entry.finish();
    work.recordings.push_back(std::move(recording));
    if (work.recordings.back().sensors.empty() ||
        !are_of_one_rig(work.recordings.front(), work.recordings.back()))
      entry.refuse("sensors", "must be those of the first recording");
  }
  if (work.recordings.empty()) object.refuse("recordings", "must not be empty");
  object.finish();
  return work;
}

}  // namespace trilat
