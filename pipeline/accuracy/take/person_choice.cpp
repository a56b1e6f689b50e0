// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <fmt/format.h>

#include "datasets/base/median.h"
#include "evaluators/bodies/match_persons.h"
#include "pipeline/accuracy/take/take_checks.h"

namespace trilat {
namespace {

constexpr std::array kTrunk{Joint::spine_base,    Joint::spine_mid,      Joint::spine_shoulder,
                            Joint::shoulder_left, Joint::shoulder_right, Joint::hip_left,
                            Joint::hip_right};

// Farther from the markers than this, their middle in the median, is not whom they are on.
constexpr double kMaxDistance_m = 1.0;

// The bodies of all sensors, one tracklet an identity.
struct Tracklets {
  std::vector<Tracklet> all;
  std::vector<std::uint64_t> identity;  // of each
  std::uint64_t frames_with_several = 0, jumps = 0;
};

std::optional<Eigen::Vector3d> centre_of(const ObservedBody& body) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const Joint joint : kTrunk) {
    if (!body.has(joint)) continue;
    sum += body.at(joint);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

void add_tracklets(const PlannedTake& planned, const SensorBodies& bodies, std::size_t sensor,
                   Tracklets& tracklets) {
  tracklets.jumps += bodies.jumps;
  std::map<std::uint64_t, std::size_t> of_id;
  for (const SensorFrame& frame : bodies.frames) {
    if (frame.bodies.size() > 1) ++tracklets.frames_with_several;
    for (const IdentifiedBody& seen : frame.bodies) {
      const auto centre = centre_of(seen.body);
      if (!centre) continue;
      const auto [it, is_new] = of_id.emplace(seen.identity, tracklets.all.size());
      if (is_new) {
        tracklets.all.push_back({sensor, {}, {}});
        tracklets.identity.push_back(seen.identity);
      }
      Tracklet& tracklet = tracklets.all[it->second];
      if (!tracklet.time_ns.empty() && frame.time.ns <= tracklet.time_ns.back()) continue;
      tracklet.time_ns.push_back(frame.time.ns);
      tracklet.centre_in_world_m.push_back(planned.world_from_sensor[sensor] * *centre);
    }
  }
}

// Centre of the markers at one instant; NaN where there are none.
Eigen::Vector3d truth_centre(const PersonTake& data, std::size_t instant, std::size_t joints) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (std::size_t j = 0; j < joints; ++j) {
    const Eigen::Vector3d& point = data.truth(instant, j, joints);
    if (!point.allFinite()) continue;
    sum += point;
    count += 1.0;
  }
  return sum / count;
}

// Horizontal distances of a person's bodies from the markers; infinite when they never meet in time.
double median_distance_m(const Plan& plan, const PersonTake& data, const Tracklets& tracklets,
                         const std::vector<std::size_t>& persons, std::size_t person) {
  std::vector<double> distances_m;
  for (std::size_t k = 0; k < tracklets.all.size(); ++k) {
    if (persons[k] != person) continue;
    const Tracklet& tracklet = tracklets.all[k];
    for (std::size_t n = 0; n < tracklet.time_ns.size(); ++n) {
      const double at =
          std::round((HostTime{tracklet.time_ns[n]} - data.time.front()).seconds() * plan.study.rate_hz);
      if (at < 0.0 || at >= static_cast<double>(data.time.size())) continue;
      const Eigen::Vector3d off = tracklet.centre_in_world_m[n] -
                                  truth_centre(data, static_cast<std::size_t>(at), plan.joints.size());
      if (off.allFinite()) distances_m.push_back(std::hypot(off.x(), off.z()));
    }
  }
  return distances_m.empty() ? std::numeric_limits<double>::infinity() : upper_median(distances_m);
}

// Whether one sensor sees two persons, given by their tracklets, at the same time.
bool are_together(const Tracklets& tracklets, const std::vector<std::size_t>& one,
                  const std::vector<std::size_t>& other) {
  for (const std::size_t a : one)
    for (const std::size_t b : other) {
      const Tracklet &first = tracklets.all[a], &second = tracklets.all[b];
      if (first.sensor == second.sensor && first.time_ns.front() <= second.time_ns.back() &&
          second.time_ns.front() <= first.time_ns.back())
        return true;
    }
  return false;
}

// The nearest, and those who are about as near and whom no sensor sees beside one that was taken: whoever was
// out of sight for long is matched as somebody else.
std::vector<std::size_t> taken_persons(const Tracklets& tracklets, const std::vector<std::size_t>& persons,
                                       const std::vector<double>& distance_m) {
  std::vector<std::vector<std::size_t>> tracklets_of(distance_m.size());
  for (std::size_t k = 0; k < persons.size(); ++k) tracklets_of[persons[k]].push_back(k);
  std::vector<std::size_t> order(distance_m.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order,
                           [&](std::size_t a, std::size_t b) { return distance_m[a] < distance_m[b]; });
  std::vector<std::size_t> taken;
  for (const std::size_t p : order) {
    const bool first = taken.empty();
    if (!first &&
        distance_m[p] > std::min(kMaxDistance_m, distance_m[taken.front()] + PersonOptions{}.same_m))
      break;
    if (std::ranges::none_of(taken, [&](std::size_t other) {
          return are_together(tracklets, tracklets_of[p], tracklets_of[other]);
        }))
      taken.push_back(p);
  }
  return taken;
}

Tracklets tracklets_of(const PlannedTake& planned, const RigBodies& seen) {
  Tracklets tracklets;
  for (std::size_t s = 0; s < seen.size(); ++s) add_tracklets(planned, seen[s], s, tracklets);
  return tracklets;
}

// The bodies of these persons, by sensor.
template <typename IsTaken>
PersonChoice bodies_of(const Tracklets& tracklets, const PersonMatch& match, std::size_t sensors,
                       const IsTaken& is_taken) {
  PersonChoice choice;
  choice.identities.resize(sensors);
  for (std::size_t k = 0; k < tracklets.all.size(); ++k)
    if (is_taken(match.person_of_tracklet[k]))
      choice.identities[tracklets.all[k].sensor].insert(tracklets.identity[k]);
  choice.sees_several = tracklets.frames_with_several > 0;
  return choice;
}

// Person 0 has the most frames.
std::optional<PersonChoice> most_seen_person(const Tracklets& tracklets, const PersonMatch& match,
                                             std::size_t sensors) {
  if (match.persons < 2) return std::nullopt;
  PersonChoice choice = bodies_of(tracklets, match, sensors, [](std::size_t p) { return p == 0; });
  choice.note = fmt::format(
      "matched across sensors, its bodies are {} persons, of whom the one with the most frames was taken",
      match.persons);
  return choice;
}

}  // namespace

std::optional<PersonChoice> choose_person(const Plan& plan, const PlannedTake& planned, const RigBodies& seen,
                                          const PersonTake& data) {
  const Tracklets tracklets = tracklets_of(planned, seen);
  const PersonMatch match = match_persons(tracklets.all, {});
  if (data.truth_m.empty()) return most_seen_person(tracklets, match, plan.rig.size());
  const std::vector<std::size_t>& persons = match.person_of_tracklet;
  std::vector<double> distance_m;
  for (std::size_t p = 0; p < match.persons; ++p)
    distance_m.push_back(median_distance_m(plan, data, tracklets, persons, p));
  const std::vector<std::size_t> taken = taken_persons(tracklets, persons, distance_m);
  const double nearest_m = taken.empty() ? kNaN : distance_m[taken.front()];
  const auto is_taken = [&](std::size_t p) { return std::ranges::find(taken, p) != taken.end(); };
  std::size_t elsewhere = 0;  // those of whom nothing is known do not count
  for (std::size_t p = 0; p < match.persons; ++p)
    if (std::isfinite(distance_m[p]) && !is_taken(p)) ++elsewhere;
  if (tracklets.frames_with_several == 0) {
    if (elsewhere == 0) return std::nullopt;
    if (!(nearest_m <= kMaxDistance_m))
      return tracklets.jumps > 0 ? most_seen_person(tracklets, match, plan.rig.size()) : std::nullopt;
  }
  PersonChoice choice = bodies_of(tracklets, match, plan.rig.size(), is_taken);
  choice.note = choice.sees_several
                    ? fmt::format("{} frames hold several bodies; matched across sensors they are {} persons",
                                  tracklets.frames_with_several, match.persons)
                    : fmt::format(
                          "no sensor sees two bodies at once, but those of different sensors or times lie as "
                          "far apart as {} persons do",
                          match.persons);
  choice.note += fmt::format(
      ", of whom the one nearest to the ground truth was taken (in the median {:.2f} m from the middle of "
      "the markers)",
      nearest_m);
  if (taken.size() > 1)
    choice.note += fmt::format(", and {} about as near whom no sensor sees beside it", taken.size() - 1);
  return choice;
}

}  // namespace trilat
