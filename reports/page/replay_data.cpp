// SPDX-License-Identifier: MIT
#include "reports/page/replay_data.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/item_store.h"
#include "datasets/skeleton/skeleton.h"
#include "reports/figures/figure_look.h"
#include "reports/page/html.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

// As in the figures.
std::vector<std::string> colours_of(const std::vector<std::string>& methods) {
  std::vector<std::string> colours;
  for (const std::string& method : methods) colours.push_back(look_of_method(method).colour);
  return colours;
}

constexpr std::int16_t kNone = -32768;
constexpr double kFarthest_mm = 32'767.0;

std::int16_t millimetres(double metres) {
  const double mm = std::round(metres * 1e3);
  return std::isfinite(mm) && std::abs(mm) <= kFarthest_mm ? static_cast<std::int16_t>(mm) : kNone;
}

// Appends channels as differences.
class Packer {
 public:
  void add16(std::uint64_t instants, const auto& value) {
    std::uint16_t before = 0;
    for (std::uint64_t i = 0; i < instants; ++i) {
      const auto now = static_cast<std::uint16_t>(value(i));
      const auto difference = static_cast<std::uint16_t>(now - before);
      bytes_ += static_cast<char>(difference & 0xff);
      bytes_ += static_cast<char>(difference >> 8);
      before = now;
    }
  }
  void add8(std::uint64_t instants, const auto& value) {
    std::uint8_t before = 0;
    for (std::uint64_t i = 0; i < instants; ++i) {
      const std::uint8_t now = value(i);
      bytes_ += static_cast<char>(static_cast<std::uint8_t>(now - before));
      before = now;
    }
  }
  std::string compressed() const { return deflated(bytes_); }

 private:
  std::string bytes_;
};

bool is_usable(const TakeHead& header, std::uint8_t status) {
  if (status >= header.status_names.size()) return false;
  const std::string& name = header.status_names[status];
  return name == "converged" || name == "closed_form" || name == "clamped";
}

void pack_sensors(const Replay& replay, Packer& packer) {
  const std::size_t row = replay.sensors.size() * kJointCount;
  for (std::size_t c = 0; c < row * 3; ++c)
    packer.add16(replay.instants,
                 [&](std::uint64_t i) { return millimetres(double{replay.joint_m[i * row * 3 + c]}); });
}

// `shown`: methods, by their numbers in the samples.
void pack_samples(const TakeHead& header, const SampleBlock& block, const std::vector<std::size_t>& shown,
                  Packer& packer) {
  const std::size_t joints = header.joints.size(), methods = header.methods.size();
  for (std::size_t c = 0; c < joints * 3; ++c)
    packer.add16(block.instants,
                 [&](std::uint64_t i) { return millimetres(block.truth_m[i * joints * 3 + c]); });
  for (std::size_t j = 0; j < joints; ++j)
    for (const std::size_t m : shown)
      for (std::size_t axis = 0; axis < 3; ++axis)
        packer.add16(block.instants, [&](std::uint64_t i) {
          const std::size_t at = (i * joints + j) * methods + m;
          return is_usable(header, block.status[at]) ? millimetres(block.estimate_m[at * 3 + axis]) : kNone;
        });
}

void pack_states(const Replay& replay, Packer& packer) {
  const std::size_t row = replay.sensors.size() * kJointCount;
  for (std::size_t c = 0; c < row; ++c)
    packer.add8(replay.instants, [&](std::uint64_t i) { return replay.state[i * row + c]; });
}

Json sensors_json(const Replay& replay) {
  Json sensors = Json::array();
  for (std::size_t s = 0; s < replay.sensors.size(); ++s) {
    const Eigen::Quaterniond& q = replay.world_from_sensor[s].rotation;
    const Eigen::Vector3d& t = replay.world_from_sensor[s].translation_m;
    sensors.push_back({{"name", replay.sensors[s]},
                       {"quaternion", {q.x(), q.y(), q.z(), q.w()}},
                       {"position_m", {t.x(), t.y(), t.z()}}});
  }
  return sensors;
}

Json skeleton_json() {
  Json names = Json::array(), parents = Json::array();
  for (int j = 0; j < kJointCount; ++j) {
    const auto joint = static_cast<Joint>(j);
    names.push_back(std::string(name_of(joint)));
    const auto parent = parent_of(joint);
    parents.push_back(parent ? static_cast<int>(*parent) : -1);
  }
  return {{"names", names}, {"parents", parents}};
}

PackedReplay pack(const Replay& replay, const StoredTake& take, const ResultsSummary& summary) {
  const TakeHead& head = take.head();
  const SampleBlock block = take.read(0, 0, replay.instants, SampleColumns::errors);
  Packer packer;
  pack_sensors(replay, packer);
  const std::vector<std::string> leading = leading_methods(summary, head.condition);
  std::vector<std::size_t> shown;
  std::vector<std::string> names;
  for (std::size_t m = 0; m < head.methods.size(); ++m)
    if (std::ranges::find(leading, head.methods[m]) != leading.end()) {
      shown.push_back(m);
      names.push_back(head.methods[m]);
    }
  pack_samples(head, block, shown, packer);
  pack_states(replay, packer);
  const double span_s =
      replay.instants < 2 ? 0.0 : static_cast<double>(block.time_ns.back() - block.time_ns.front()) * 1e-9;
  const Json json{{"study", summary.study},
                  {"take", head.id},
                  {"condition", head.condition},
                  {"simulated", summary.simulated},
                  {"instants", replay.instants},
                  {"span_s", span_s},
                  {"sensors", sensors_json(replay)},
                  {"skeleton", skeleton_json()},
                  {"joints", head.joints},
                  {"methods", names},
                  {"colours", colours_of(names)},
                  {"view_deg", {70.6, 60.0}},  // of a Kinect v2
                  {"range_m", {0.5, 4.5}}};
  return {summary.study + ": " + head.condition + ", take " + head.id, json_text(json, -1),
          packer.compressed()};
}

}  // namespace

std::vector<PackedReplay> packed_replays(const std::filesystem::path& results,
                                         const ResultsSummary& summary) {
  std::vector<PackedReplay> packed;
  for (const ResultTake& take : result_takes(results)) {
    if (take.folder.empty()) continue;
    const StoredTake file = open_take(take);
    const std::optional<Replay> replay = file.read_replay();
    if (replay && replay->instants > 0) packed.push_back(pack(*replay, file, summary));
  }
  return packed;
}

}  // namespace trilat
