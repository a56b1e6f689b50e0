// SPDX-License-Identifier: MIT
#include "pipeline/person_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/session/session_clock.h"
#include "evaluators/bodies/match_persons.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 512;
constexpr std::array kTrunk{Joint::spine_base,    Joint::spine_mid,      Joint::spine_shoulder,
                            Joint::shoulder_left, Joint::shoulder_right, Joint::hip_left,
                            Joint::hip_right};

// The bodies of all sensors, one tracklet a tracking id.
struct Tracklets {
  std::vector<Tracklet> all;
  std::vector<std::uint64_t> tracking_id;  // of each
  std::uint64_t frames_with_several = 0;
};

std::optional<Eigen::Vector3d> centre_of(const Body& body) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const Joint joint : kTrunk) {
    const auto j = static_cast<std::size_t>(joint);
    const Eigen::Vector3d point(static_cast<double>(body.position_m[j][0]),
                                static_cast<double>(body.position_m[j][1]),
                                static_cast<double>(body.position_m[j][2]));
    if (body.tracking_state[j] == 0 || !point.allFinite()) continue;
    sum += point;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

void read_tracklets(const PlannedTake& planned, const SessionReader& session, std::size_t sensor,
                    const std::function<bool()>& stop_requested, Tracklets& tracklets) {
  const std::size_t number = planned.session_sensor[sensor];
  const SensorDescription& description = session.header().sensors[number];
  std::map<std::uint64_t, std::size_t> of_id;
  const std::uint64_t frames = session.counts(number).body_frames;
  for (std::uint64_t first = 0; first < frames; first += kBlock) {
    if (stop_requested && stop_requested()) throw Interrupted();
    for (const BodyFrame& frame : session.body_frames(number, first, std::min(kBlock, frames - first))) {
      if (frame.bodies.size() > 1) ++tracklets.frames_with_several;
      const HostTime t = planned.host_from_sensor[sensor](device_time(description, frame.stamp));
      for (const Body& body : frame.bodies) {
        const auto centre = centre_of(body);
        if (!centre) continue;
        const auto [it, is_new] = of_id.emplace(body.tracking_id, tracklets.all.size());
        if (is_new) {
          tracklets.all.push_back({sensor, {}, {}});
          tracklets.tracking_id.push_back(body.tracking_id);
        }
        Tracklet& tracklet = tracklets.all[it->second];
        if (!tracklet.time_ns.empty() && t.ns <= tracklet.time_ns.back()) continue;
        tracklet.time_ns.push_back(t.ns);
        tracklet.centre_in_world_m.push_back(planned.world_from_sensor[sensor] * *centre);
      }
    }
  }
}

// Where the markers are at one instant; NaN where there are none.
Eigen::Vector3d truth_centre(const TakeData& data, std::size_t instant, std::size_t joints) {
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
double median_distance_m(const Plan& plan, const TakeData& data, const Tracklets& tracklets,
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
  if (distances_m.empty()) return std::numeric_limits<double>::infinity();
  const auto middle = distances_m.begin() + static_cast<std::ptrdiff_t>(distances_m.size() / 2);
  std::nth_element(distances_m.begin(), middle, distances_m.end());
  return *middle;
}

}  // namespace

std::optional<PersonChoice> choose_person(const Plan& plan, const PlannedTake& planned,
                                          const SessionReader& session, const TakeData& data,
                                          const std::function<bool()>& stop_requested) {
  Tracklets tracklets;
  for (std::size_t s = 0; s < plan.rig.size(); ++s)
    read_tracklets(planned, session, s, stop_requested, tracklets);
  if (tracklets.frames_with_several == 0) return std::nullopt;
  const PersonMatch match = match_persons(tracklets.all, {});
  const std::vector<std::size_t>& persons = match.person_of_tracklet;
  std::size_t best = 0;
  std::vector<double> distance_m;
  for (std::size_t p = 0; p < match.persons; ++p) {
    distance_m.push_back(median_distance_m(plan, data, tracklets, persons, p));
    if (distance_m[p] < distance_m[best]) best = p;
  }
  PersonChoice choice;
  choice.tracking_ids.resize(plan.rig.size());
  for (std::size_t k = 0; k < persons.size(); ++k)
    if (persons[k] == best) choice.tracking_ids[tracklets.all[k].sensor].insert(tracklets.tracking_id[k]);
  choice.note = fmt::format(
      "{} frames hold several bodies; matched across sensors they are {} persons, of whom the one nearest to "
      "the "
      "ground truth was taken (in the median {:.2f} m from the middle of the markers)",
      tracklets.frames_with_several, match.persons, distance_m.empty() ? kNaN : distance_m[best]);
  return choice;
}

}  // namespace trilat
