// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_views.h"

#include <algorithm>

namespace trilat {
namespace {

void add_evidence(SensorEvidence& evidence, const SensorSearch& search,
                  const std::vector<RestingBall>& rests) {
  evidence.frames += search.frames;
  for (const auto& [name, count] : search.statuses) evidence.statuses[name] += count;
  for (const RestingBall& ball : rests) {
    const double distance_m = ball.centre_in_sensor_m.norm();
    evidence.nearest_m = evidence.rests == 0 ? distance_m : std::min(evidence.nearest_m, distance_m);
    evidence.farthest_m = std::max(evidence.farthest_m, distance_m);
    ++evidence.rests;
  }
}

// Whether a sensor that saw both saw the ball in one place.
bool are_one_place(const WandPosition& a, const WandPosition& b, double within_m) {
  for (const RestingBall& one : a.seen)
    for (const RestingBall& other : b.seen)
      if (one.sensor == other.sensor)
        return (one.centre_in_sensor_m - other.centre_in_sensor_m).norm() < within_m;
  return false;
}

}  // namespace

void add_recording(WandViews& views, const WandRecording& recording, std::span<const SensorSearch> searches,
                   const WandPositionOptions& options) {
  const bool first = views.evidence.empty();
  if (first)
    for (const RecordedSensor& sensor : recording.sensors)
      views.evidence.push_back({.name = sensor.name, .statuses = {}});
  std::vector<RestingBall> rests;
  for (std::size_t s = 0; s < searches.size(); ++s) {
    const std::vector<RestingBall> more = find_rests(searches[s].found, s, options);
    add_evidence(views.evidence[s], searches[s], more);
    rests.insert(rests.end(), more.begin(), more.end());
  }
  // One recording at a time: the host clocks of two need not be the same.
  auto positions = find_wand_positions(std::move(rests), options);
  views.positions.insert(views.positions.end(), positions.begin(), positions.end());
  views.simulated = views.simulated || recording.simulated;
  if (first) views.positions_of_first = views.positions.size();
}

std::vector<bool> sensors_that_saw(const WandViews& views) {
  std::vector<bool> saw(views.evidence.size(), false);
  for (const WandPosition& position : views.positions)
    for (const RestingBall& ball : position.seen) saw[ball.sensor] = true;
  return saw;
}

// Places that only one sensor saw say nothing of where it stands beside the others, and a hand that drifts
// may make two rests of one place.
void keep_useful_positions(WandViews& views) {
  constexpr double kSamePlace_m = 0.05;
  std::vector<WandPosition> kept;
  std::size_t kept_of_first = 0;
  for (std::size_t p = 0; p < views.positions.size(); ++p) {
    const WandPosition& position = views.positions[p];
    const bool again = !kept.empty() && are_one_place(kept.back(), position, kSamePlace_m);
    if (again || (position.seen.size() < 2 && views.evidence.size() > 1)) continue;
    kept.push_back(position);
    if (p < views.positions_of_first) kept_of_first = kept.size();
  }
  views.positions = std::move(kept);
  views.positions_of_first = kept_of_first;
}

std::optional<double> seen_movement_m(const WandViews& views) {
  double sum_m = 0.0, count = 0.0;
  for (const RestingBall& first : views.positions[0].seen)
    for (const RestingBall& second : views.positions[1].seen)
      if (first.sensor == second.sensor) {
        sum_m += (second.centre_in_sensor_m - first.centre_in_sensor_m).norm();
        count += 1.0;
      }
  if (count == 0.0) return std::nullopt;
  return sum_m / count;
}

}  // namespace trilat
