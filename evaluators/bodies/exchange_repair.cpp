// SPDX-License-Identifier: MIT
#include "evaluators/bodies/exchange_repair.h"

#include <algorithm>
#include <array>
#include <utility>

#include "datasets/base/error.h"
#include "evaluators/bodies/exchange_evidence.h"

namespace trilat {
namespace {

// A state is a set of exchanged sensors, one bit a sensor.
constexpr std::size_t kMaxStates = std::size_t{1} << kMaxSensors;
using Costs = std::array<double, kMaxStates>;
using Origins = std::array<std::uint8_t, kMaxStates>;

// What the evidence of one instant says against each state, up to a constant.
void costs_of(const ExchangeEvidence& evidence, std::size_t sensors, double reluctance, Costs& costs) {
  costs[0] = 0.0;
  for (std::size_t b = 0; b < sensors; ++b) {
    const std::size_t bit = std::size_t{1} << b;
    const double alone = evidence.seen[b] ? evidence.labels_right[b] + reluctance : 0.0;
    for (std::size_t state = 0; state < bit; ++state) {
      double cost = costs[state] + alone;
      for (std::size_t c = 0; c < sensors; ++c)
        cost += (state >> c & 1u) ? -evidence.alike[b][c] : evidence.alike[b][c];
      costs[state | bit] = cost;
    }
  }
}

// The least cost of coming to each state when every sensor may begin or end to exchange, and where from.
void step(const ExchangeEvidence& evidence, std::size_t sensors, double switching_cost, Costs& total,
          Origins& origin) {
  const std::size_t states = std::size_t{1} << sensors;
  for (std::size_t state = 0; state < states; ++state) origin[state] = static_cast<std::uint8_t>(state);
  for (std::size_t b = 0; b < sensors; ++b) {
    if (!evidence.seen[b]) continue;  // what happens meanwhile is weighed when the sensor sees again
    const double stay = std::max(-evidence.as_before[b], 0.0);
    const double change = std::max(evidence.as_before[b], 0.0) + switching_cost;
    const std::size_t bit = std::size_t{1} << b;
    for (std::size_t low = 0; low < states; ++low) {
      if (low & bit) continue;
      const std::size_t high = low | bit;
      const double at_low = total[low], at_high = total[high];
      const std::uint8_t from_low = origin[low], from_high = origin[high];
      const bool to_low = at_high + change < at_low + stay, to_high = at_low + change < at_high + stay;
      total[low] = to_low ? at_high + change : at_low + stay;
      total[high] = to_high ? at_low + change : at_high + stay;
      if (to_low) origin[low] = from_high;
      if (to_high) origin[high] = from_low;
    }
  }
}

bool has_any(const ObservedBody& body) {
  return std::any_of(body.state.begin(), body.state.end(),
                     [](TrackingState state) { return state != TrackingState::not_tracked; });
}

// What speaks for this course of exchanges against its opposite, in which each sensor is exchanged where it
// is not here: sensors that agree with each other and with themselves do so in both.
double certainty_of(const ExchangeRepair& repair, std::span<const double> labels_right) {
  double certainty = 0.0;
  for (std::size_t i = 0; i < labels_right.size(); ++i)
    certainty += repair.exchanged[i] ? -labels_right[i] : labels_right[i];
  return certainty;
}

void count_stretches(const BodyTracks& tracks, ExchangeRepair& repair) {
  repair.stretches.assign(repair.sensors, 0);
  for (std::size_t a = 0; a < repair.sensors; ++a) {
    bool before = false;
    for (std::size_t i = 0; i < tracks.instants(); ++i) {
      if (!has_any(tracks.at(i, a))) continue;
      repair.stretches[a] += repair.at(i, a) && !before;
      before = repair.at(i, a);
    }
  }
}

}  // namespace

ExchangeRepair find_exchanges(const BodyTracks& tracks, std::span<const RigidTransform> world_from_sensor,
                              const ExchangeOptions& options) {
  const std::size_t sensors = tracks.sensors(), instants = tracks.instants();
  TRILAT_CHECK(world_from_sensor.size() == sensors && sensors <= kMaxSensors,
               "every sensor has one pose and the rig is within the capacity");
  ExchangeRepair repair{sensors, std::vector<std::uint8_t>(instants * sensors, 0), {}};
  const std::size_t states = std::size_t{1} << sensors;
  const double reluctance = sensors == 1 ? options.reluctance_alone : options.reluctance;
  ExchangeEvidenceSource source(tracks, world_from_sensor, options);
  std::vector<std::uint8_t> origins(instants * states);
  std::vector<double> labels_right;  // instants x sensors
  Costs total{}, costs;
  Origins origin;
  for (std::size_t i = 0; i < instants; ++i) {
    const ExchangeEvidence evidence = source.next();
    step(evidence, sensors, i == 0 ? 0.0 : options.switching_cost, total, origin);
    std::copy_n(origin.begin(), states, origins.begin() + static_cast<std::ptrdiff_t>(i * states));
    labels_right.insert(labels_right.end(), evidence.labels_right.begin(),
                        evidence.labels_right.begin() + static_cast<std::ptrdiff_t>(sensors));
    costs_of(evidence, sensors, reluctance, costs);
    for (std::size_t state = 0; state < states; ++state) total[state] += costs[state];
  }
  const auto end = total.begin() + static_cast<std::ptrdiff_t>(states);
  auto state = static_cast<std::size_t>(std::min_element(total.begin(), end) - total.begin());
  for (std::size_t i = instants; i-- > 0; state = origins[i * states + state])
    for (std::size_t a = 0; a < sensors; ++a)
      repair.exchanged[i * sensors + a] = (state >> a & 1u) && has_any(tracks.at(i, a));
  if (certainty_of(repair, labels_right) < options.least_certainty)
    std::fill(repair.exchanged.begin(), repair.exchanged.end(), std::uint8_t{0});
  count_stretches(tracks, repair);
  return repair;
}

void undo_exchanges(BodyTracks& tracks, const ExchangeRepair& repair) {
  TRILAT_CHECK(
      repair.sensors == tracks.sensors() && repair.exchanged.size() == tracks.instants() * tracks.sensors(),
      "the repair belongs to these tracks");
  for (std::size_t i = 0; i < tracks.instants(); ++i) {
    for (std::size_t a = 0; a < tracks.sensors(); ++a) {
      if (!repair.at(i, a)) continue;
      ObservedBody& body = tracks.at(i, a);
      for (std::size_t j = 0; j < kJointCount; ++j) {
        const auto mirror = static_cast<std::size_t>(mirror_of(static_cast<Joint>(j)));
        if (mirror <= j) continue;
        std::swap(body.joint_in_sensor_m[j], body.joint_in_sensor_m[mirror]);
        std::swap(body.state[j], body.state[mirror]);
      }
    }
  }
}

}  // namespace trilat
