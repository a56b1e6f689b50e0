// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/truth_track.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/base/error.h"
#include "datasets/mocap/frozen_filter.h"
#include "datasets/mocap/optitrack_csv_reader.h"
#include "evaluators/alignment/interpolation.h"

namespace trilat {
namespace {

constexpr double kNaNumber = std::numeric_limits<double>::quiet_NaN();

std::vector<std::size_t> resolve(const JointMapping::Entry& entry, const MocapHeader& header,
                                 const std::filesystem::path& mapping_file) {
  const std::string place = mapping_file.string() + " /joints/" + std::string(name_of(entry.joint));
  std::vector<std::size_t> assets;
  for (const std::string& key : entry.assets) {
    assets.push_back(find_asset(header, key, place));
    const MocapAsset& asset = header.assets[assets.back()];
    if (header.coordinate_space == "Local" &&
        (asset.type == AssetType::bone || asset.type == AssetType::bone_marker))
      throw InputError(place, "names \"" + key +
                                  "\", whose positions are relative to its parent; export again with the "
                                  "coordinate space Global");
    if (!asset.has_position)
      throw InputError(place, "names the asset \"" + key + "\", of which the export holds no position");
  }
  return assets;
}

}  // namespace

struct TruthTrack::State {
  OptitrackCsvReader reader;
  FrozenFilter frames;
  Duration longest_gap;
  std::vector<std::vector<std::size_t>> assets_of_joint;
  std::deque<MocapFrame> window;  // around the time last asked for, longest_gap to both sides
  MocapTime last_read;
  bool ended = false;

  State(const std::filesystem::path& mocap, Duration gap) : reader(mocap), frames(reader), longest_gap(gap) {}

  void move_to(MocapTime t) {
    while (!ended && (window.empty() || window.back().time < t + longest_gap)) {
      MocapFrame frame;
      if (!frames.next(frame)) {
        ended = true;
        break;
      }
      last_read = frame.time;
      window.push_back(std::move(frame));
    }
    while (!window.empty() && window.front().time < t - longest_gap) window.pop_front();
  }

  Eigen::Vector3d asset_at(std::size_t asset, MocapTime t) const {
    const auto later = std::lower_bound(window.begin(), window.end(), t,
                                        [](const MocapFrame& f, MocapTime when) { return f.time < when; });
    auto after = later;
    while (after != window.end() && !after->poses[asset].has_position()) ++after;
    auto before = later;
    while (before != window.begin() && !(before - 1)->poses[asset].has_position()) --before;
    const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaNumber);
    if (after == window.end()) return none;
    if (after->time == t) return after->poses[asset].position_m;
    if (before == window.begin()) return none;
    --before;
    return interpolate(t, before->time, before->poses[asset].position_m, after->time,
                       after->poses[asset].position_m, longest_gap)
        .value_or(none);
  }
};

TruthTrack::TruthTrack(const std::filesystem::path& mocap, const JointMapping& mapping,
                       const std::filesystem::path& mapping_file, const std::vector<Joint>& joints,
                       Duration longest_gap)
    : state_(std::make_unique<State>(mocap, longest_gap)) {
  std::vector<std::size_t> wanted;
  for (Joint joint : joints) {
    std::vector<std::size_t> assets;
    for (const auto& entry : mapping.joints)
      if (entry.joint == joint) assets = resolve(entry, state_->reader.header(), mapping_file);
    wanted.insert(wanted.end(), assets.begin(), assets.end());
    state_->assets_of_joint.push_back(std::move(assets));
  }
  state_->reader.read_only(wanted);
}

TruthTrack::~TruthTrack() = default;
TruthTrack::TruthTrack(TruthTrack&&) noexcept = default;

void TruthTrack::at(MocapTime t, std::span<Eigen::Vector3d> joints) {
  state_->move_to(t);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto& assets = state_->assets_of_joint[j];
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t asset : assets) sum += state_->asset_at(asset, t);
    joints[j] = assets.empty() ? Eigen::Vector3d::Constant(kNaNumber)
                               : Eigen::Vector3d(sum / static_cast<double>(assets.size()));
  }
}

MocapTime TruthTrack::read_to_end() {
  while (!state_->ended) state_->move_to(state_->last_read + state_->longest_gap);
  return state_->last_read;
}

std::uint64_t TruthTrack::samples_frozen() const {
  std::uint64_t sum = 0;
  for (const std::int64_t removed : state_->frames.removed()) sum += static_cast<std::uint64_t>(removed);
  return sum;
}

const MocapAnomalies& TruthTrack::anomalies() const { return state_->reader.anomalies(); }

}  // namespace trilat
