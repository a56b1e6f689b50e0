// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/tracking_check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "datasets/base/error.h"
#include "datasets/session/clock/session_clock.h"
#include "datasets/session/session_reader.h"
#include "datasets/skeleton/skeleton.h"
#include "datasets/synthetic/tracker/tracker_truth.h"

namespace trilat {
namespace {

// Of each instant and sensor what the simulator knows of the frame nearest in time; nothing between frames.
class TruthAtInstants {
 public:
  TruthAtInstants(const Plan& plan, const PlannedTake& planned, const TakeData& data)
      : sensors_(plan.rig.size()) {
    if (planned.take.tracker_truth.empty()) return;
    const TrackerTruthReader reader(planned.take.tracker_truth);
    const SessionReader session(planned.take.session);
    truth_.resize(data.time.size() * sensors_);
    for (std::size_t s = 0; s < sensors_; ++s) read_sensor(plan, planned, data, session, reader, s);
  }
  bool known() const { return !truth_.empty(); }
  const std::optional<TrackerTruth>& at(std::size_t instant, std::size_t sensor) const {
    return truth_[instant * sensors_ + sensor];
  }

 private:
  void read_sensor(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                   const SessionReader& session, const TrackerTruthReader& reader, std::size_t s) {
    const std::size_t number = planned.session_sensor[s];
    std::map<std::int64_t, TrackerTruth> of_sequence;
    for (const TrackerTruth& truth : reader.read(plan.rig[s], 0, reader.frames(plan.rig[s])))
      of_sequence[truth.sequence] = truth;
    std::map<HostTime, std::int64_t> sequence_at;
    for (const FrameStamp& stamp :
         session.stamps(number, FrameStream::bodies, 0, session.counts(number).body_frames))
      sequence_at[planned.host_from_sensor[s](stamp)] = stamp.sequence;
    const Duration reach = duration_from_s(plan.study.sensor_gap_s);
    for (std::size_t i = 0; i < data.time.size(); ++i) {
      const HostTime t = data.time[i];
      auto nearest = sequence_at.lower_bound(t);
      if (nearest == sequence_at.end() ||
          (nearest != sequence_at.begin() && t - std::prev(nearest)->first < nearest->first - t))
        --nearest;
      if (std::max(nearest->first - t, t - nearest->first) > reach) continue;
      const auto truth = of_sequence.find(nearest->second);
      if (truth != of_sequence.end()) truth_[i * sensors_ + s] = truth->second;
    }
  }

  std::size_t sensors_;
  std::vector<std::optional<TrackerTruth>> truth_;
};

struct Rule {
  std::string name;
  std::size_t occlusion = 0;       // of OcclusionRule, or 0 for what the tracker says
  const Method* method = nullptr;  // or what this method rejects
};

std::vector<Rule> rules_of(const Plan& plan, const TakeData& data) {
  constexpr std::array<const char*, kOcclusionRules> kNames{"inferred", "crossed, printed",
                                                            "crossed, corrected", "hidden in depth"};
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

// Whether the simulator hid the joint of the person that the body calls `joint` after what was repaired.
bool truly_hidden(const TrackerTruth& truth, Joint joint, bool put_right) {
  const Joint meant = truth.exchanged != put_right ? mirror_of(joint) : joint;
  return (truth.hidden >> static_cast<unsigned>(meant) & 1u) != 0;
}

std::vector<ViewRow> count_views(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                                 const TruthAtInstants& truth) {
  const std::size_t sensors = plan.rig.size();
  const std::vector<Rule> rules = rules_of(plan, data);
  std::vector<ViewRow> rows;  // by joint, sensor and rule
  for (const Joint joint : plan.joints)
    for (std::size_t s = 0; s < sensors; ++s)
      for (const Rule& rule : rules)
        rows.push_back(
            {planned.take.activity, plan.rig[s], table_group(joint), rule.name, 0, 0, truth.known(), 0, 0});
  std::vector<JointObservation> observations(sensors);
  for (std::size_t i = 0; i < data.time.size(); ++i)
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      const Joint joint = plan.joints[j];
      observe_joint(data, i, joint, planned.world_from_sensor, observations);
      const JointInstant instant{observations, planned.world_from_sensor, occlusions_of(data, i, joint), {}};
      for (std::size_t r = 0; r < rules.size(); ++r) {
        const SensorMask used = rules[r].method ? sensors_of(*rules[r].method, instant) : SensorMask();
        for (std::size_t s = 0; s < sensors; ++s) {
          if (!observations[s].seen || (truth.known() && !truth.at(i, s))) continue;
          if (rules[r].method && !rules[r].method->allowed[s]) continue;
          ViewRow& row = rows[(j * sensors + s) * rules.size() + r];
          const bool rejected = rejects(rules[r], instant, s, used);
          const bool hidden =
              truth.known() &&
              truly_hidden(*truth.at(i, s), joint, plan.study.repair_exchanges && data.exchanges.at(i, s));
          ++row.views;
          row.rejected += rejected;
          row.hidden += hidden;
          row.rightly += rejected && hidden;
        }
      }
    }
  return rows;
}

ExchangeRow count_exchanges(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                            const TruthAtInstants& truth, std::size_t s) {
  ExchangeRow row{planned.take.activity, plan.rig[s], 0, 0, data.exchanges.stretches[s],
                  truth.known(),         0,           0, 0, 0};
  std::uint64_t run = 0, run_found = 0;  // of the truly exchanged stretch that goes on
  const auto end_run = [&] {
    if (run == 0) return;
    ++row.true_stretches;
    row.stretches_found += 20 * run_found >= 19 * run;
    run = run_found = 0;
  };
  for (std::size_t i = 0; i < data.time.size(); ++i) {
    const ObservedBody& body = data.bodies.at(i, s);
    const bool there = std::ranges::any_of(
        body.state, [](TrackingState state) { return state != TrackingState::not_tracked; });
    if (!there || (truth.known() && !truth.at(i, s))) continue;
    const bool found = data.exchanges.at(i, s);
    ++row.instants;
    row.found += found;
    if (!truth.known()) continue;
    if (!truth.at(i, s)->exchanged) {
      end_run();
      continue;
    }
    ++row.exchanged;
    row.rightly += found;
    ++run;
    run_found += found;
  }
  end_run();
  return row;
}

std::vector<RangeSums> sum_ranges(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  std::vector<RangeSums> sums;  // by joint
  for (const Joint joint : plan.joints)
    sums.push_back({planned.take.activity, table_group(joint), 0, 0.0, 0.0});
  std::vector<JointObservation> observations(plan.rig.size());
  for (std::size_t i = 0; i < data.time.size(); ++i)
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      const Eigen::Vector3d& truth_m = data.truth(i, j, plan.joints.size());
      if (!truth_m.allFinite()) continue;
      observe_joint(data, i, plan.joints[j], planned.world_from_sensor, observations);
      for (std::size_t s = 0; s < observations.size(); ++s) {
        if (!observations[s].seen) continue;
        const double error_m =
            observations[s].range_m - (truth_m - planned.world_from_sensor[s].translation_m).norm();
        ++sums[j].n;
        sums[j].sum_m += error_m;
        sums[j].squares_m2 += error_m * error_m;
      }
    }
  return sums;
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
  const TruthAtInstants truth(plan, planned, data);
  TakeTracking tracking;
  tracking.views = count_views(plan, planned, data, truth);
  for (std::size_t s = 0; s < plan.rig.size(); ++s)
    tracking.exchanges.push_back(count_exchanges(plan, planned, data, truth, s));
  if (!data.truth_m.empty()) tracking.ranges = sum_ranges(plan, planned, data);
  tracking.clock = data.clock;
  tracking.clock.take = planned.take.id;
  return tracking;
}

TrackingSummary sum_tracking(const Plan& plan, const std::vector<TakeTracking>& takes) {
  TrackingSummary summary{plan.study.name, plan.simulated, plan.study.repair_exchanges, {}, {}, {}};
  std::vector<RangeSums> ranges;
  std::vector<PredictionSums> predictions;
  for (const TakeTracking& take : takes) {
    predictions.insert(predictions.end(), take.predictions.begin(), take.predictions.end());
    merge_rows(
        summary.views, take.views,
        [](const ViewRow& row) { return std::tie(row.condition, row.sensor, row.group, row.rule); },
        [](ViewRow& sum, const ViewRow& row) {
          sum.views += row.views;
          sum.rejected += row.rejected;
          sum.truth_known = sum.truth_known && row.truth_known;
          sum.hidden += row.hidden;
          sum.rightly += row.rightly;
        });
    merge_rows(
        summary.exchanges, take.exchanges,
        [](const ExchangeRow& row) { return std::tie(row.condition, row.sensor); },
        [](ExchangeRow& sum, const ExchangeRow& row) {
          sum.instants += row.instants;
          sum.found += row.found;
          sum.stretches += row.stretches;
          sum.truth_known = sum.truth_known && row.truth_known;
          sum.exchanged += row.exchanged;
          sum.rightly += row.rightly;
          sum.true_stretches += row.true_stretches;
          sum.stretches_found += row.stretches_found;
        });
    merge_rows(
        ranges, take.ranges, [](const RangeSums& row) { return std::tie(row.condition, row.group); },
        [](RangeSums& sum, const RangeSums& row) {
          sum.n += row.n;
          sum.sum_m += row.sum_m;
          sum.squares_m2 += row.squares_m2;
        });
    if (!take.clock.status.empty()) summary.clocks.push_back(take.clock);
    if (!take.rays.take.empty()) summary.rays.push_back(take.rays);
    summary.corrections.insert(summary.corrections.end(), take.corrections.begin(), take.corrections.end());
  }
  for (const RangeSums& r : ranges) {
    const double n = static_cast<double>(r.n);
    summary.ranges.push_back({r.condition, r.group, r.n, r.sum_m / n, std::sqrt(r.squares_m2 / n)});
  }
  summary.predictions = prediction_rows(predictions);
  return summary;
}

}  // namespace trilat
