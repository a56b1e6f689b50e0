// SPDX-License-Identifier: MIT
#include "datasets/results/replay.h"

#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "datasets/hdf5/hdf5_file.h"
#include "datasets/skeleton/skeleton.h"

namespace trilat {
namespace {

constexpr const char* kFile = "replay.h5";
constexpr const char* kReplayFormat = "trilat.replay";
constexpr std::int64_t kReplayVersion = 2;
constexpr std::uint64_t kPoseNumbers = 7;         // quaternion w, x, y, z and position x, y, z
constexpr std::uint64_t kMaxInstants = 1u << 20;  // far beyond what is ever written
constexpr std::size_t kMaxSensors = 64;

std::vector<double> pose_numbers(const std::vector<RigidTransform>& poses) {
  std::vector<double> numbers;
  for (const RigidTransform& pose : poses) {
    const Eigen::Quaterniond& q = pose.rotation;
    const Eigen::Vector3d& t = pose.translation_m;
    numbers.insert(numbers.end(), {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
  }
  return numbers;
}

RigidTransform pose_of(const double* n, const std::string& place) {
  RigidTransform pose{{n[0], n[1], n[2], n[3]}, {n[4], n[5], n[6]}};
  const bool unit = std::abs(pose.rotation.norm() - 1.0) < 1e-6;
  if (!unit || !pose.translation_m.allFinite()) throw InputError(place, "world_from_sensor is no pose");
  return pose;
}

void write_take(H5Node node, const ReplayTake& take) {
  node.set_text("id", take.id);
  node.set_text("condition", take.condition);
  node.set_texts("sensors", take.sensors);
  const std::uint64_t sensors = take.sensors.size();
  const std::vector<double> poses = pose_numbers(take.world_from_sensor);
  node.create_table("world_from_sensor", H5Type::f64, {kPoseNumbers}, {}, sensors)
      .write(0, std::span<const double>(poses));
  node.create_table("joint_m", H5Type::f32, {sensors, kJointCount, 3}, {}, take.instants)
      .write(0, std::span<const float>(take.joint_m));
  node.create_table("state", H5Type::u8, {sensors, kJointCount}, {}, take.instants)
      .write(0, std::span<const std::uint8_t>(take.state));
}

ReplayTake read_take(const H5Node& node) {
  ReplayTake take;
  take.id = node.text("id");
  take.condition = node.text("condition");
  take.sensors = node.texts("sensors");
  const std::size_t sensors = take.sensors.size();
  const H5Table poses = node.table("world_from_sensor", H5Type::f64, {kPoseNumbers});
  if (sensors == 0 || sensors > kMaxSensors || poses.rows() != sensors)
    throw InputError(node.place(), "must have a pose for each of 1 to 64 sensors");
  std::vector<double> numbers(sensors * kPoseNumbers);
  poses.read(0, std::span<double>(numbers));
  for (std::size_t s = 0; s < sensors; ++s)
    take.world_from_sensor.push_back(pose_of(&numbers[s * kPoseNumbers], node.place()));
  const H5Table joints = node.table("joint_m", H5Type::f32, {sensors, kJointCount, 3});
  const H5Table states = node.table("state", H5Type::u8, {sensors, kJointCount});
  if (joints.rows() != states.rows() || joints.rows() > kMaxInstants)
    throw InputError(node.place(), "joint_m and state differ in length, or are too long");
  take.reset(joints.rows(), sensors);
  joints.read(0, std::span<float>(take.joint_m));
  states.read(0, std::span<std::uint8_t>(take.state));
  return take;
}

}  // namespace

void ReplayTake::reset(std::uint64_t count, std::size_t sensor_count) {
  instants = count;
  joint_m.assign(count * sensor_count * kJointCount * 3, std::numeric_limits<float>::quiet_NaN());
  state.assign(count * sensor_count * kJointCount, static_cast<std::uint8_t>(TrackingState::not_tracked));
}

void write_replay(const std::filesystem::path& folder, const ReplayTake& take) {
  const std::filesystem::path path = folder / kFile;
  H5File file = H5File::create(path);
  file.set_text("format", kReplayFormat);
  file.set_integer("version", kReplayVersion);
  file.set_text("created_by", kProgramVersion);
  write_take(file.create_group("take"), take);
  file.close();
  sync_file(path);
}

std::optional<ReplayTake> read_replay(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kFile;
  if (!std::filesystem::exists(path)) return std::nullopt;
  const H5File file = H5File::open(path);
  if (!file.has_attribute("format") || file.text("format") != kReplayFormat)
    throw InputError(path.string(), "is not a replay file of this program");
  if (file.integer("version") != kReplayVersion)
    throw InputError(path.string(),
                     fmt::format("is another version; this program reads version {}", kReplayVersion));
  return read_take(file.group("take"));
}

}  // namespace trilat
