// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/external/external_joints.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/mocap/read_mocap.h"
#include "pipeline/accuracy/proposals.h"

namespace trilat {
namespace {

bool has_world_position(const MocapHeader& header, const MocapAsset& asset) {
  return asset.has_position && (asset.type != AssetType::bone || header.coordinate_space == "Global");
}

// Every asset by its own name, the measured marker before what was solved under the same name. What a system
// calls unlabelled has a number that means nothing in another file.
NamedPoints points_by_name(const MocapHeader& header) {
  NamedPoints points;
  for (std::size_t i = 0; i < header.assets.size(); ++i) {
    const MocapAsset& asset = header.assets[i];
    if (!has_world_position(header, asset) || plain_name(asset.name).starts_with("unlabel")) continue;
    const auto known = std::ranges::find(points, asset.name, &NamedPoint::name);
    if (known == points.end())
      points.push_back({asset.name, {key_of(header, i)}});
    else if (asset.type == AssetType::marker && !known->assets[0].starts_with("marker:"))
      known->assets = {key_of(header, i)};
  }
  return points;
}

// Refuses a point that stands twice in the file: two persons, or a marker that was labelled twice.
void refuse_doubled(const MocapHeader& header, const std::string& name, const std::string& place) {
  const MocapAsset* first = nullptr;
  for (const MocapAsset& asset : header.assets) {
    if (asset.name != name || !has_world_position(header, asset)) continue;
    if (!first || (first->type != AssetType::marker && asset.type == AssetType::marker)) {
      first = &asset;
    } else if (asset.type == first->type) {
      throw InputError(
          place, fmt::format("has \"{}\" twice, in columns {} and {}; say under \"mapping\" which one is "
                             "meant, or keep one person's columns",
                             name, first->column, asset.column));
    }
  }
}

NamedPoints proposed_points(const MocapHeader& header) {
  NamedPoints points;
  for (JointMapping::Entry& entry : propose_mapping(header).joints)
    points.push_back({std::string(name_of(entry.joint)), std::move(entry.assets)});
  return points;
}

const NamedPoint* find_point(const NamedPoints& points, const std::string& name) {
  const auto same = std::ranges::find(points, name, &NamedPoint::name);
  if (same != points.end()) return &*same;
  const auto alike = std::ranges::find_if(
      points, [&](const NamedPoint& point) { return plain_name(point.name) == plain_name(name); });
  return alike == points.end() ? nullptr : &*alike;
}

// "Ann:LASI" -> "lasi".
std::string without_subject(const std::string& name) { return plain_name(name.substr(name.rfind(':') + 1)); }

// The only point that has the name but for the subject before the colon; none where several persons have it.
const NamedPoint* find_point_of_subject(const NamedPoints& points, const std::vector<std::string>& names,
                                        const std::string& name) {
  const std::string wanted = without_subject(name);
  const auto of_point = [](const NamedPoint& point) { return without_subject(point.name); };
  if (std::ranges::count(names, wanted, without_subject) != 1 ||
      std::ranges::count(points, wanted, of_point) != 1)
    return nullptr;
  return &*std::ranges::find(points, wanted, of_point);
}

// Whether the names of the file tell that a point is another joint than it is called: the bone Head begins at
// the neck.
bool is_another(const NamedPoints& told, const NamedPoint& point, const std::string& name) {
  const auto joint = std::ranges::find(told, point.assets, &NamedPoint::assets);
  return joint != told.end() && joint->name != name;
}

// The points of a file that have these names: by its mapping; else by its own names, or the joints that these
// stand for.
NamedPoints points_called(const ExternalJoints& joints, const MocapHeader& header,
                          const std::vector<std::string>& names) {
  const NamedPoints own = joints.mapping.empty() ? points_by_name(header) : joints.mapping;
  const NamedPoints told = joints.mapping.empty() ? proposed_points(header) : NamedPoints{};
  NamedPoints points;
  for (const std::string& name : names) {
    const auto unless_another = [&](const NamedPoint* point) {
      return point && joint_from_name(name) && is_another(told, *point, name) ? nullptr : point;
    };
    const NamedPoint* point = unless_another(find_point(own, name));
    if (point && joints.mapping.empty()) refuse_doubled(header, point->name, joints.file.string());
    if (!point) point = find_point(told, name);
    if (!point) point = unless_another(find_point_of_subject(own, names, name));
    if (point) points.push_back({name, point->assets});
  }
  return points;
}

std::string names_text(const std::vector<std::string>& names) {
  constexpr std::size_t kMaxCount = 12;
  const std::size_t shown = std::min(kMaxCount, names.size());
  const std::string text =
      fmt::format("{}", fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "));
  return names.size() > shown ? fmt::format("{} and {} more", text, names.size() - shown) : text;
}

std::vector<std::string> names_of(const NamedPoints& points) {
  std::vector<std::string> names;
  for (const NamedPoint& point : points) names.push_back(point.name);
  return names;
}

// The names of a file's points; where it has none, why not.
std::string points_text(const MocapHeader& header) {
  const std::vector<std::string> names = names_of(points_by_name(header));
  if (!names.empty()) return names_text(names);
  const auto any = [&](const auto& is_such) { return std::ranges::any_of(header.assets, is_such); };
  if (any([](const MocapAsset& asset) { return asset.type == AssetType::bone && asset.has_position; }))
    return "bones relative to their parents alone; export again with the coordinate space Global";
  return any([](const MocapAsset& asset) { return asset.has_position; })
             ? "unlabelled markers alone; label them in the motion capture's program"
             : "nothing with a position";
}

std::vector<std::vector<std::size_t>> markers_of(const MocapHeader& header, const NamedPoints& points,
                                                 const std::vector<std::string>& names,
                                                 const std::string& place) {
  std::vector<std::vector<std::size_t>> markers;
  for (const std::string& name : names) {
    markers.emplace_back();
    const auto point = std::ranges::find(points, name, &NamedPoint::name);
    if (point != points.end()) markers.back() = assets_of_joint(header, point->assets, place + " /" + name);
  }
  refuse_same_assets(names, markers, place + " /");
  return markers;
}

// How the person stands in the mocap, where its points are joints: z, y, or nothing where that is not clear.
std::optional<UpAxis> standing_axis(const MocapTake& positions, const NamedPoints& points) {
  UpAxisEstimator standing;
  constexpr std::size_t kMaxCount = 300;  // frames, spread evenly
  const std::size_t step = std::max<std::size_t>(1, positions.time.size() / kMaxCount);
  for (const NamedPoint& point : points) {
    const auto joint = joint_from_name(point.name);
    if (!joint) continue;
    for (const std::size_t marker : assets_of_joint(positions.header, point.assets, point.name))
      for (std::size_t frame = 0; frame < positions.time.size(); frame += step)
        standing.add(*joint, positions.position_m[marker][frame]);
  }
  return standing.axis();
}

}  // namespace

MocapHeader read_marker_header(const std::filesystem::path& file) {
  return is_joint_csv(file) ? read_joint_csv(file).header : read_mocap_header(file);
}

MocapTake read_markers(const std::filesystem::path& file) {
  if (is_joint_csv(file)) return read_joint_csv(file);
  const MocapHeader header = read_mocap_header(file);
  std::vector<std::size_t> assets;
  for (std::size_t i = 0; i < header.assets.size(); ++i)
    if (has_world_position(header, header.assets[i])) assets.push_back(i);
  return read_positions(file, {.assets = assets});
}

NamedPoints correspondences(const Take& take) {
  const MocapHeader header = read_marker_header(take.mocap);
  std::vector<MocapHeader> external;
  for (const ExternalJoints& joints : take.joints) external.push_back(read_marker_header(joints.file));
  const auto common = [&](const NamedPoints& points) {
    NamedPoints both;
    std::set<std::string> names;
    for (std::size_t k = 0; k < external.size(); ++k)
      for (const NamedPoint& point : points_called(take.joints[k], external[k], names_of(points)))
        names.insert(point.name);
    for (const NamedPoint& point : points)
      if (names.contains(point.name)) both.push_back(point);
    return both;
  };
  std::vector<NamedPoints> ways;
  if (take.mapping.empty())
    ways = {points_by_name(header), proposed_points(header)};
  else
    ways = {read_points(take.mapping)};
  NamedPoints best = common(ways[0]);
  if (take.mapping.empty()) {
    const NamedPoints proposed = common(ways[1]);
    if (proposed.size() > best.size()) return proposed;
    for (NamedPoint& point : best) {
      refuse_doubled(header, point.name, take.mocap.string());
      // Angles and groups know the joint that the name means.
      const auto joint = std::ranges::find(proposed, point.assets, &NamedPoint::assets);
      if (joint != proposed.end()) point.name = joint->name;
    }
  }
  if (!best.empty()) return best;
  throw InputError(
      take.joints.front().file.string(),
      fmt::format("has no point that {} has: here are {}; there {}. Say which is which with a mapping",
                  take.mocap.filename().string(), points_text(external.front()),
                  take.mapping.empty() ? points_text(header) : names_text(names_of(ways.front()))));
}

std::vector<std::string> unmatched_points(const Take& take, const std::vector<std::string>& names) {
  std::vector<std::string> left_out;
  if (!take.mapping.empty())
    for (const NamedPoint& point : read_points(take.mapping))
      if (std::ranges::find(names, point.name) == names.end()) left_out.push_back(point.name);
  if (left_out.empty()) return {};
  return {fmt::format("names {} that are in none of the files, and not compared", names_text(left_out))};
}

void open_external_take(PlannedTake& planned, const StudySpec& study) {
  const Take& take = planned.take;
  planned.points = correspondences(take);
  const MocapTake positions = read_markers(take.mocap);
  if (positions.time.empty()) throw InputError(take.mocap.string(), "holds no frames");
  planned.simulated = positions.header.is_simulated();
  planned.start = HostTime{} + duration_from_s(positions.first_s);
  planned.instants = static_cast<std::uint64_t>(
                         std::floor((positions.time.back() - MocapTime{}).seconds() * study.rate_hz + 1e-6)) +
                     1;
  constexpr std::uint64_t kMaxCount = 2'000'000;  // a take is held in memory: 18 hours at 30 Hz
  if (planned.instants > kMaxCount)
    throw InputError(take.mocap.string(),
                     fmt::format("is longer than can be evaluated at {} Hz", study.rate_hz));
  planned.truth_has_z_up = take.up_axis == UpAxis::z;
  if (!take.up_axis && standing_axis(positions, planned.points) == UpAxis::z)
    throw InputError(take.mocap.string(), kStandsAlongZ);
  planned.in_mocap_world = true;
  planned.ok = true;
}

MarkerTrack truth_of_points(const Plan& plan, const PlannedTake& planned) {
  MocapTake positions = read_markers(planned.take.mocap);
  auto markers =
      markers_of(positions.header, planned.points, plan.names,
                 (planned.take.mapping.empty() ? planned.take.mocap : planned.take.mapping).string());
  return {std::move(positions), std::move(markers), duration_from_s(plan.study.truth_gap_s),
          planned.truth_has_z_up};
}

std::vector<ExternalTrack> read_external(const Plan& plan, const PlannedTake& planned) {
  std::vector<ExternalTrack> all;
  for (const ExternalJoints& joints : planned.take.joints) {
    MocapTake positions = read_markers(joints.file);
    const NamedPoints points = points_called(joints, positions.header, plan.names);
    if (points.empty())
      throw InputError(
          joints.file.string(),
          fmt::format(
              "has none of {}; it has {}. Say which is which under \"mapping\"", names_text(plan.names),
              joints.mapping.empty() ? points_text(positions.header) : names_text(names_of(joints.mapping))));
    auto markers = markers_of(positions.header, points, plan.names, joints.file.string() + " /mapping");
    std::set<std::size_t> used;
    for (const std::vector<std::size_t>& of_point : markers) used.insert(of_point.begin(), of_point.end());
    std::vector<std::string> left_out;
    for (std::size_t i = 0; i < positions.header.assets.size(); ++i)
      if (!used.contains(i)) left_out.push_back(positions.header.assets[i].name);
    if (joints.mapping.empty())
      if (std::string text = bones_text(positions.header); !text.empty())
        positions.taken_as.push_back(std::move(text));
    std::size_t method = 0;
    while (plan.methods[method].spec.name != joints.method) ++method;
    // without a session both files have the same clock
    double first_s = positions.first_s - (plan.rig.empty() ? (planned.start - HostTime{}).seconds() : 0.0);
    constexpr double kOtherClock_s = 1e8;  // three years
    if (std::abs(first_s) > kOtherClock_s) {
      positions.taken_as.push_back(
          fmt::format("begins at {:.3f} s, by another clock than the {}, such as that of seconds since 1970: "
                      "taken to begin "
                      "with it",
                      positions.first_s, plan.rig.empty() ? "truth" : "recording"));
      first_s = 0.0;
    }
    const double rate_hz = positions.time.size() < 2 ? plan.study.rate_hz
                                                     : static_cast<double>(positions.time.size() - 1) /
                                                           positions.time.back().ns * 1e9;
    constexpr double kGapsOfFrames = 1.6, kMaxGap_s = 0.5;
    const double gap_s = std::max(plan.study.sensor_gap_s, std::min(kMaxGap_s, kGapsOfFrames / rate_hz));
    all.push_back({&joints, method,
                   MarkerTrack(std::move(positions), std::move(markers), duration_from_s(gap_s),
                               plan.rig.empty() && planned.truth_has_z_up),
                   first_s, 0.0, std::move(left_out)});
  }
  return all;
}

void points_at(const ExternalTrack& external, double since_s, std::span<Eigen::Vector3d> points) {
  external.track.at(MocapTime{} + duration_from_s(since_s - external.offset_s - external.first_s), points);
}

MethodTrajectories paths_of(const Plan& plan, const ExternalTrack& external,
                            const std::vector<double>& since_s) {
  const std::size_t count = plan.names.size();
  MethodTrajectories paths{external.method, count, std::vector<TrajectoryPoint>(since_s.size() * count)};
  std::vector<Eigen::Vector3d> points(count);
  for (std::size_t i = 0; i < since_s.size(); ++i) {
    points_at(external, since_s[i], points);
    for (std::size_t j = 0; j < count; ++j)
      paths.points[i * count + j] = {
          points[j], points[j].allFinite() ? SolveStatus::given : SolveStatus::no_observation, 0};
  }
  return paths;
}

}  // namespace trilat
