// SPDX-License-Identifier: MIT
#include "pipeline/tracker/measure_tracker.h"

#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/synthetic/generated_person.h"
#include "datasets/synthetic/tracker/body_tracker.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr double kRate_hz = 30.0;

// Sensors on an arc in front of persons who walk and stand; one clock for all.
std::vector<WatchedTake> watched(const BodyTrackerSpec& tracker, std::uint64_t seed, std::size_t participants,
                                 TruthKind truth,
                                 const std::vector<double>& places_deg = {0.0, 40.0, 100.0}) {
  std::vector<WatchedTake> takes(2 * participants);
  SensorSpec sensor_spec;
  sensor_spec.rate_hz = kRate_hz;
  parallel_for_index(takes.size(), 1, [&](std::size_t t) {
    const std::size_t participant = t / 2;
    const Activity activity = t % 2 == 0 ? Activity::walking : Activity::standing;
    const double duration_s = activity == Activity::walking ? 20.0 : 4.0;
    const SimulatedItem item{seed, t, participant};
    const Motion motion = generated_motion(draw_person(seed, participant, 1.7, 0.1), activity);
    WatchedTake& take = takes[t];
    take.participant = fmt::format("p{}", participant);
    take.truth_kind = truth;
    std::vector<BodyTracker> trackers;
    for (std::size_t s = 0; s < places_deg.size(); ++s) {
      const double angle = places_deg[s] * 3.14159265358979 / 180.0;
      SimulatedSensor sensor =
          draw_sensor(sensor_spec, item, s,
                      {"k", world_from_sensor_looking_at({2.5 * std::sin(angle), 1.2, 2.5 * std::cos(angle)},
                                                         {0.0, 1.0, 0.0})});
      sensor.unit = {};
      take.world_from_sensor.push_back(sensor.pose.world_from_sensor);
      take.intrinsics.push_back(sensor.intrinsics);
      trackers.emplace_back(tracker, sensor_spec, sensor, item, 1);
    }
    constexpr std::size_t kEvery = 1;
    const auto frames = static_cast<std::size_t>(duration_s * kRate_hz);
    take.step_s = kEvery / kRate_hz;
    take.bodies = BodyTracks(frames / kEvery, places_deg.size());
    std::vector<double> time_s;
    std::vector<ObservedBody> all;
    for (std::size_t f = 0; f < frames; ++f) {
      const SkeletonPose pose = motion(static_cast<double>(f) / kRate_hz);
      for (std::size_t s = 0; s < trackers.size(); ++s) {
        const Body body = trackers[s].observe(f, std::span(&pose, 1)).bodies.at(0);
        ObservedBody observed;
        for (std::size_t j = 0; j < kJointCount; ++j) {
          observed.joint_in_sensor_m[j] = {body.position_m[j][0], body.position_m[j][1],
                                           body.position_m[j][2]};
          observed.state[j] = static_cast<TrackingState>(body.tracking_state[j]);
        }
        if (s == 0) {
          time_s.push_back(static_cast<double>(f) / kRate_hz);
          all.push_back(observed);
        }
        if (f % kEvery == 0) take.bodies.at(f / kEvery, s) = observed;
      }
      if (f % kEvery == 0 && truth != TruthKind::none)
        take.truth_m.insert(take.truth_m.end(), pose.joint_in_world_m.begin(), pose.joint_in_world_m.end());
    }
    take.jitter_m = resting_jitter_m(time_s, all);
  });
  return takes;
}

BodyTrackerSpec declared() {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.bias_sigma_m.fill(0.025);
  spec.view_bias_sigma_m.fill(0.03);
  spec.own_bias_sigma_m.fill(0.012);
  spec.wander_sigma_m.fill(0.012);
  spec.view_wander_sigma_m.fill(0.015);
  spec.own_wander_sigma_m.fill(0.008);
  spec.wander_path_m = 0.4;
  spec.jitter_sigma_m.fill(0.001);
  spec.lag_s = 0.04;
  spec.ray_ratio = 1.3;
  spec.least_visible_share = 0.5;
  spec.inferred_error_sigma_m.fill(0.12);
  spec.hidden_as_tracked_share = 0.3;
  spec.back_view_angle_rad = 1.8;
  spec.exchanged_share = 1.0;
  return spec;
}

double declared_value(const MeasuredParameter& m) {
  const BodyTrackerSpec spec = declared();
  for (const DeclaredParameter& p : tracker_parameters(spec)) {
    if (p.name != m.name) continue;
    if (m.group.empty()) return std::stod(p.value);
    const std::size_t at = p.value.find(m.group + " ");
    return std::stod(p.value.substr(at + m.group.size() + 1));
  }
  return std::nan("");
}

std::vector<std::string> names_of(const std::vector<UntoldParameter>& untold) {
  std::vector<std::string> names;
  for (const UntoldParameter& one : untold) names.push_back(one.name);
  return names;
}

// How far off estimates are, and how many of their intervals hold what was declared.
struct Coverage {
  double held = 0.0, ratio = 0.0, count = 0.0;
};

// `least`: the share of intervals that hold; `within`: how far off estimates are in the mean, as a factor.
void expect_coverage(TruthKind kind, double least, double within, const std::set<std::string>& known_high) {
  constexpr std::uint64_t kCampaigns = 8;
  std::map<std::string, Coverage> of_parameter;
  Coverage all;
  for (std::uint64_t c = 0; c < kCampaigns; ++c)
    for (const MeasuredParameter& m : measure_tracker(watched(declared(), 100 + c, 8, kind)).measured) {
      const double truth = declared_value(m);
      EXPECT_GE(m.participants, 6u) << m.name;
      for (Coverage* coverage : {&of_parameter[m.name], &all}) {
        if (coverage == &all && known_high.contains(m.name)) continue;
        coverage->held += truth >= m.low && truth <= m.high ? 1.0 : 0.0;
        coverage->ratio += m.value / truth;
        coverage->count += 1.0;
      }
    }
  EXPECT_GT(all.held / all.count, least);
  EXPECT_LT(all.held / all.count, 0.985);
  for (const auto& [name, coverage] : of_parameter) {
    const double ratio = coverage.ratio / coverage.count;
    EXPECT_GT(ratio, 1.0 / within) << name;
    EXPECT_LT(ratio, known_high.contains(name) ? 1.35 : within) << name;
  }
}

TEST(MeasureTracker, IntervalsHoldTheDeclaredValuesAgainstAnExactTruth) {
  expect_coverage(TruthKind::exact, 0.92, 1.09, {"own_wander_sigma_m"});
}

// Where a body faces is known from what the sensors see alone. That error looks like the sensors' own wander.
TEST(MeasureTracker, IntervalsHoldTheDeclaredValuesOfSensorsAmongThemselves) {
  expect_coverage(TruthKind::none, 0.9, 1.09, {"own_wander_sigma_m"});
}

TEST(MeasureTracker, WhatTakesDoNotTellIsNamedAndStaysAsDeclared) {
  using testing::IsSupersetOf;
  const auto told = [](TruthKind kind, const std::vector<double>& places_deg) {
    return measure_tracker(watched(declared(), 7, 2, kind, places_deg));
  };
  TrackerMeasurement found = told(TruthKind::none, {0.0, 60.0});
  EXPECT_THAT(names_of(found.untold), IsSupersetOf({"bias_sigma_m", "wander_sigma_m", "lag_s"}));
  for (const MeasuredParameter& m : found.measured) EXPECT_NE(m.name, "lag_s");
  for (const MeasuredParameter& m : found.measured)
    EXPECT_TRUE(std::isnan(m.low)) << m.name;  // of two persons
  found = told(TruthKind::none, {0.0});
  EXPECT_THAT(names_of(found.untold),
              IsSupersetOf({"view_bias_sigma_m", "own_bias_sigma_m", "view_wander_sigma_m",
                            "own_wander_sigma_m", "wander_path_m", "inferred_error_sigma_m", "ray_ratio"}));
  found = told(TruthKind::markers, {0.0, 60.0});
  EXPECT_THAT(names_of(found.untold), IsSupersetOf({"bias_sigma_m", "lag_s"}));
  for (const char* name : {"wander_sigma_m", "view_bias_sigma_m", "own_bias_sigma_m"})
    EXPECT_THAT(names_of(found.untold), testing::Not(testing::Contains(name)));
}

// Markers on wrists alone do not say where a person faces; the sensors do.
TEST(MeasureTracker, SensorsTellAmongThemselvesWhereMarkersAreFew) {
  std::vector<WatchedTake> takes = watched(declared(), 5, 4, TruthKind::markers);
  for (WatchedTake& take : takes)
    for (std::size_t k = 0; k < take.truth_m.size(); ++k)
      if (k % kJointCount != static_cast<std::size_t>(Joint::wrist_left))
        take.truth_m[k] = Vector3d::Constant(std::nan(""));
  const TrackerMeasurement found = measure_tracker(takes);
  for (const char* name : {"view_bias_sigma_m", "back_view_angle_rad", "exchanged_share"})
    EXPECT_THAT(names_of(found.untold), testing::Not(testing::Contains(name)));
  for (const MeasuredParameter& m : found.measured)
    if (m.name == "exchanged_share") {
      EXPECT_GT(m.value, 0.95);
    }
}

// Hidden joints that err like all others say nothing of when a joint counts as hidden.
TEST(MeasureTracker, WithoutGrossErrorsTheVisibleShareIsNotGuessed) {
  BodyTrackerSpec spec = declared();
  spec.inferred_error_sigma_m.fill(0.0);
  EXPECT_THAT(names_of(measure_tracker(watched(spec, 9, 3, TruthKind::exact)).untold),
              testing::Contains("least_visible_share"));
}

// Who only stands says nothing of what comes with motion, nor what of a difference is bias.
TEST(MeasureTracker, PersonsWhoStandTellNoWander) {
  std::vector<WatchedTake> takes = watched(declared(), 3, 4, TruthKind::none);
  std::erase_if(takes, [](const WatchedTake& take) { return take.bodies.instants() > 200; });
  const TrackerMeasurement found = measure_tracker(takes);
  EXPECT_THAT(names_of(found.untold),
              testing::IsSupersetOf({"own_wander_sigma_m", "wander_path_m", "own_bias_sigma_m"}));
}

}  // namespace
}  // namespace trilat
