// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/tracking_check.h"

#include <algorithm>
#include <tuple>

#include "datasets/skeleton/skeleton.h"

namespace trilat {
namespace {

struct Rule {
  std::string name;
  std::size_t occlusion = 0;       // of OcclusionRule, or 0 for what the tracker says
  const Method* method = nullptr;  // or what this method rejects
};

std::vector<Rule> rules_of(const Plan& plan, const TakeData& data) {
  constexpr std::array<const char*, kOcclusionRules> kNames{"inferred", "crossed, printed",
                                                            "crossed, corrected"};
  std::vector<Rule> rules;
  for (std::size_t k = 0; k < kOcclusionRules; ++k)
    if (k == 0 || !data.occlusions[k].empty()) rules.push_back({kNames[k], k, nullptr});
  for (const Method& method : plan.methods)
    if (method.spec.occlusion != OcclusionRule::off)
      rules.push_back({"method: " + method.spec.name, 0, &method});
  return rules;
}

bool rejects(const Rule& rule, const JointInstant& instant, std::size_t sensor, SensorMask used) {
  if (rule.method) return !used[sensor];
  if (rule.occlusion == 0) return instant.observations[sensor].state == TrackingState::inferred;
  return instant.occlusions[rule.occlusion][sensor] > 0;
}

std::vector<ViewRow> count_views(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  const std::size_t sensors = plan.rig.size();
  const std::vector<Rule> rules = rules_of(plan, data);
  std::vector<ViewRow> rows;  // by joint, sensor and rule
  for (const Joint joint : plan.joints)
    for (std::size_t s = 0; s < sensors; ++s)
      for (const Rule& rule : rules)
        rows.push_back({planned.take.activity, plan.rig[s], table_group(joint), rule.name});
  std::vector<JointObservation> observations(sensors);
  for (std::size_t i = 0; i < data.time.size(); ++i)
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      const Joint joint = plan.joints[j];
      observe_joint(data, i, joint, planned.world_from_sensor, observations);
      const JointInstant instant{observations, planned.world_from_sensor, occlusions_of(data, i, joint), {}};
      for (std::size_t r = 0; r < rules.size(); ++r) {
        const SensorMask used = rules[r].method ? sensors_of(*rules[r].method, instant) : SensorMask();
        for (std::size_t s = 0; s < sensors; ++s) {
          if (!observations[s].seen) continue;
          if (rules[r].method && !rules[r].method->allowed[s]) continue;
          ViewRow& row = rows[(j * sensors + s) * rules.size() + r];
          ++row.views;
          row.rejected += rejects(rules[r], instant, s, used);
        }
      }
    }
  return rows;
}

ExchangeRow count_exchanges(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                            std::size_t s) {
  ExchangeRow row{planned.take.activity, plan.rig[s], 0, 0, data.exchanges.stretches[s]};
  for (std::size_t i = 0; i < data.time.size(); ++i) {
    const ObservedBody& body = data.bodies.at(i, s);
    if (std::ranges::all_of(body.state,
                            [](TrackingState state) { return state == TrackingState::not_tracked; }))
      continue;
    ++row.instants;
    row.found += data.exchanges.at(i, s);
  }
  return row;
}

template <class Row, class Key, class Add>
void merge_rows(std::vector<Row>& all, const std::vector<Row>& more, const Key& key, const Add& add) {
  for (const Row& row : more) {
    const auto found = std::ranges::find_if(all, [&](const Row& other) { return key(other) == key(row); });
    if (found == all.end())
      all.push_back(row);
    else
      add(*found, row);
  }
}

}  // namespace

TakeTracking check_tracking(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  TakeTracking tracking;
  tracking.views = count_views(plan, planned, data);
  for (std::size_t s = 0; s < plan.rig.size(); ++s)
    tracking.exchanges.push_back(count_exchanges(plan, planned, data, s));
  tracking.clock = data.clock;
  tracking.clock.take = planned.take.id;
  return tracking;
}

TrackingSummary sum_tracking(const Plan& plan, const std::vector<TakeTracking>& takes) {
  TrackingSummary summary{plan.study.name, plan.simulated, plan.study.repair_exchanges, {}, {}, {}};
  std::vector<PredictionSums> predictions;
  for (const TakeTracking& take : takes) {
    predictions.insert(predictions.end(), take.predictions.begin(), take.predictions.end());
    merge_rows(
        summary.views, take.views,
        [](const ViewRow& row) { return std::tie(row.condition, row.sensor, row.group, row.rule); },
        [](ViewRow& sum, const ViewRow& row) {
          sum.views += row.views;
          sum.rejected += row.rejected;
        });
    merge_rows(
        summary.exchanges, take.exchanges,
        [](const ExchangeRow& row) { return std::tie(row.condition, row.sensor); },
        [](ExchangeRow& sum, const ExchangeRow& row) {
          sum.instants += row.instants;
          sum.found += row.found;
          sum.stretches += row.stretches;
        });
    if (!take.clock.status.empty()) summary.clocks.push_back(take.clock);
    if (!take.rays.take.empty()) summary.rays.push_back(take.rays);
    summary.corrections.insert(summary.corrections.end(), take.corrections.begin(), take.corrections.end());
  }
  summary.predictions = prediction_rows(predictions);
  return summary;
}

}  // namespace trilat
