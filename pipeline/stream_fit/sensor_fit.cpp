// SPDX-License-Identifier: MIT
#include "pipeline/stream_fit/sensor_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {
namespace {

constexpr double kNoPush_m = 0.08;  // mean distance below which no push is looked for
constexpr StreamFitOptions kLookedFor{
    .min_start_s = 0.08,
    .max_start_s = 3.0,
    .min_scale = 0.08,
    .causes = kSizeCause | kStartCause | kShiftCause | kTurnCause | kMirrorCause,
    .alpha = 0.02};  // a clock that is off shows while a person moves, which may be in every second block
constexpr std::size_t kMinPairs = 100;  // points of two sensors; fewer decide nothing
constexpr double kPushedShare = 0.7, kMinPushed_m = 0.15;
constexpr double kSound_m = 0.05;  // mean distance between sensors below which no change of all is looked for
constexpr double kMinLag_s = 0.08;     // by movements
constexpr double kNearerShare = 0.98;  // of the distance may be left without the lag
constexpr double kSureLag_s = 0.05;    // less its uncertainty, a lag is larger

using Sensors = std::vector<std::size_t>;

PointStream moved(const PointStream& stream, const RigidTransform& by) {
  PointStream result = stream;
  for (Eigen::Vector3d& at_m : result.at_m) at_m = by * at_m;
  return result;
}

class SensorsFitter {
 public:
  SensorsFitter(const std::vector<SensorStream>& sensors, const std::optional<UprightPoints>& upright)
      : sensors_(sensors), looks_(sensors, upright) {
    for (const SensorStream& s : sensors) in_world_.push_back(moved(s.in_sensor, s.world_from_sensor));
  }

  SensorsFit run() {
    SensorsFit fit;
    fit.groups = groups_as_stated();
    const RigChange as_stated{same_order(sensors_.size())};
    fit.before_m = fit.after_m = looks_.distance_m(as_stated);
    fit.height_m = looks_.height_m(as_stated);
    if (fit.groups.size() > 1 || fit.height_m < kUpsideDown_m || fit.before_m > kSound_m) {
      fit.rig = looks_.change_of_all(fit.groups.size() == 1);
      if (fit.rig) {
        fit.after_m = looks_.distance_m(*fit.rig);
        Sensors all;
        for (const Sensors& group : fit.groups) all.insert(all.end(), group.begin(), group.end());
        std::ranges::sort(all);
        fit.groups = {all};
      }
    }
    const Sensors& sound = fit.groups.empty() ? Sensors{} : fit.groups.front();
    for (std::size_t s = 0; s < sensors_.size(); ++s)
      fit.apart_m.push_back(mean_distance_m(in_world_[s], mean_of(sound, s)));
    if (fit.rig || fit.groups.empty()) return fit;
    if (fit.groups.size() > 1 && (sound.size() > 1 || sensors_.size() == 2)) name_outside(fit);
    if (fit.groups.size() == 1) find_late(fit);
    if (fit.groups.size() == 1) find_pushed(fit);
    return fit;
  }

 private:
  // Greedy cliques of sensors that agree, the largest first.
  std::vector<Sensors> groups_as_stated() const {
    const std::size_t count = sensors_.size();
    std::vector<std::vector<bool>> agree(count, std::vector<bool>(count, false));
    std::vector<bool> sees(count, false);
    for (std::size_t a = 0; a < count; ++a) {
      sees[a] = looks_.sees_any(a);
      for (std::size_t b = 0; b < a; ++b) agree[a][b] = agree[b][a] = agree_as_stated(b, a);
    }
    Sensors left;
    for (std::size_t s = 0; s < count; ++s)
      if (sees[s]) left.push_back(s);
    std::vector<Sensors> groups;
    while (!left.empty()) {
      Sensors largest;
      for (const std::size_t seed : left) {
        Sensors group{seed};
        for (const std::size_t s : left)
          if (s != seed && std::ranges::all_of(group, [&](std::size_t g) { return agree[s][g]; }))
            group.push_back(s);
        if (group.size() > largest.size()) largest = group;
      }
      std::ranges::sort(largest);
      groups.push_back(largest);
      std::erase_if(left, [&](std::size_t s) { return std::ranges::binary_search(largest, s); });
    }
    return groups;
  }

  bool agree_as_stated(std::size_t a, std::size_t b) const {
    const double apart_m = mean_distance_m(in_world_[a], in_world_[b]);
    if (std::isnan(apart_m)) return true;  // they see nothing at one time
    return !is_named(fit_of(b, in_world_[a]), apart_m);
  }

  // Whether a fit shows more than what sound trackers differ by: any difference of that size; a smaller one
  // by its clock or ranges alone, since a pose or a mirror fits the trackers' errors about one who stands.
  static bool is_named(const StreamFit& fit, double apart_m) {
    if (apart_m >= kSensorsAgree_m) return true;
    if (fit.status != StreamFitStatus::found) return false;
    const unsigned causes = causes_of(fit.changes.front());
    return causes == kStartCause || causes == kSizeCause;
  }

  // A sensor against what is given in the world.
  StreamFit fit_of(std::size_t sensor, const PointStream& others) const {
    const SensorStream& s = sensors_[sensor];
    const PointStream reference = moved(others, s.world_from_sensor.inverse());
    const StreamPair pair{reference, s.in_sensor};
    if (!can_gain(pair)) {
      StreamFit fit;
      fit.status = StreamFitStatus::sound;
      fit.before_m = fit.after_m = mean_distance_m(reference, s.in_sensor);
      return fit;
    }
    StreamFit fit = fit_streams(pair, same_order(reference.points), kLookedFor);
    choose_simplest(pair, fit);
    return fit;
  }

  // Whether any single change leaves so much less that it could earn its place; far quicker than the search.
  static bool can_gain(const StreamPair& pair) {
    const TimeBlocks blocks = blocks_of(pair);
    const auto left_m = [&](const StreamChange& change) {
      return mean_of_known(errors_of_change(pair, blocks, change).judged_m);
    };
    const double enough_m = kEarnedShare * left_m({});
    for (const bool mirrored : {false, true})
      if (left_m({.frame = FrameChange::turned, .mirrored = mirrored}) < enough_m) return true;
    constexpr std::array kLags_s{0.1, 0.2, 0.35, 0.6, 1.0, 1.5, 2.0, 2.5, 3.0};
    return std::ranges::any_of(kLags_s, [&](double lag_s) {
      return left_m({.start_s = lag_s, .has_start = true}) < enough_m ||
             left_m({.start_s = -lag_s, .has_start = true}) < enough_m;
    });
  }

  // Keeps the change with the fewest parameters of those that explain as much: that a pose turns just as a
  // person walks about a circle, or is shifted just along the rays, would be chance.
  static void choose_simplest(const StreamPair& pair, StreamFit& fit) {
    if (fit.status != StreamFitStatus::one_of) return;
    constexpr double kAsWell = 1.2;
    const TimeBlocks blocks = blocks_of(pair);
    const auto judged_m = [&](const StreamChange& change) {
      return mean_of_known(errors_of_change(pair, blocks, change).judged_m);
    };
    const int fewest = parameters_of(*std::ranges::min_element(fit.changes, {}, parameters_of));
    const double least_m = judged_m(*std::ranges::min_element(fit.changes, {}, judged_m));
    std::erase_if(fit.changes, [&](const StreamChange& change) {
      return parameters_of(change) > fewest || judged_m(change) > kAsWell * least_m;
    });
    if (fit.changes.empty()) return;
    const ChangeErrors errors = errors_of_change(pair, blocks, fit.changes.front());
    fit.after_m = mean_of_known(errors.plain_m);
    fit.of_point_m = errors.of_point_m;
    if (fit.changes.size() == 1) fit.status = StreamFitStatus::found;
  }

  static double mean_distance_m(const PointStream& a, const PointStream& b) {
    double sum_m = 0.0;
    std::size_t count = 0;
    for (std::size_t k = 0; k < a.at_m.size(); ++k)
      if (const double m = (a.at_m[k] - b.at_m[k]).norm(); std::isfinite(m)) {
        sum_m += m;
        ++count;
      }
    return count < kMinPairs ? kNaN : sum_m / static_cast<double>(count);
  }

  // Mean of some sensors but for one, in the world.
  PointStream mean_of(const Sensors& group, std::size_t without) const {
    PointStream mean = in_world_.front();
    for (std::size_t k = 0; k < mean.at_m.size(); ++k) {
      Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
      double count = 0.0;
      for (const std::size_t s : group)
        if (s != without && in_world_[s].at_m[k].allFinite()) {
          sum_m += in_world_[s].at_m[k];
          count += 1.0;
        }
      mean.at_m[k] = sum_m / count;  // NaN without any
    }
    return mean;
  }

  // The change of this sensor; where there are two, either may be at fault, and the change that explains more
  // is given.
  SensorChange change_against(std::size_t sensor, const Sensors& group) const {
    SensorChange change = change_of(sensor, mean_of(group, sensor));
    if (sensors_.size() != 2 || change.pushed_s) return change;
    const SensorChange of_other = change_of(1 - sensor, in_world_[sensor]);
    if (of_other.fit.changes.empty()) return change;
    if (change.fit.changes.empty()) return of_other;
    constexpr double kClearly = 0.8;
    const int parameters = parameters_of(change.fit.changes.front()),
              of_other_parameters = parameters_of(of_other.fit.changes.front());
    const bool is_better =
        of_other_parameters < parameters ||
        (of_other_parameters == parameters && of_other.fit.after_m < kClearly * change.fit.after_m);
    return is_better ? of_other : change;
  }

  SensorChange change_of(std::size_t sensor, const PointStream& others) const {
    SensorChange change{sensor, fit_of(sensor, others)};
    look_for_push(others, change);
    return change;
  }

  // Sensors that differ from another one alone, and not from the largest group, belong to it.
  void name_outside(SensorsFit& fit) const {
    std::vector<Sensors> groups{fit.groups.front()};
    Sensors agree;
    for (std::size_t g = 1; g < fit.groups.size(); ++g) {
      Sensors outside;
      for (const std::size_t s : fit.groups[g]) {
        SensorChange change = change_against(s, groups.front());
        if (change.pushed_s || is_named(change.fit, fit.apart_m[s])) {
          fit.changes.push_back(std::move(change));
          outside.push_back(fit.changes.back().sensor);
          if (fit.changes.back().sensor != s) groups.front() = {s};  // the other one of two
        } else {
          agree.push_back(s);
        }
      }
      if (!outside.empty()) groups.push_back(outside);
    }
    groups.front().insert(groups.front().end(), agree.begin(), agree.end());
    std::ranges::sort(groups.front());
    fit.groups = std::move(groups);
  }

  // Puts sensors outside whose movements are late, though all agree in the mean. The latest goes first, since
  // it makes the others seem early.
  void find_late(SensorsFit& fit) const {
    Sensors& group = fit.groups.front();
    Sensors late;
    while (group.size() > 1) {
      std::size_t who = sensors_.size();
      double most_s = kMinLag_s;
      bool is_late = false;
      for (const std::size_t s : group) {
        const ViewLag lag = lag_of(in_world_[s], mean_of(group, s));
        if (!(std::abs(lag.lag_s) - 2.0 * lag.sigma_s > kSureLag_s) || !(std::abs(lag.lag_s) >= most_s))
          continue;
        most_s = std::abs(lag.lag_s);
        is_late = lag.lag_s > 0.0;
        who = s;
      }
      if (who == sensors_.size()) break;
      const SensorStream& s = sensors_[who];
      const PointStream reference = moved(mean_of(group, who), s.world_from_sensor.inverse());
      const StreamPair pair{reference, s.in_sensor};
      SensorChange change{who, {}};
      change.fit.status = StreamFitStatus::found;
      change.fit.changes = {{.start_s = is_late ? -most_s : most_s, .has_start = true}};
      change.fit.before_m = mean_distance_m(reference, s.in_sensor);
      change.fit.after_m =
          mean_of_known(errors_of_change(pair, blocks_of(pair), change.fit.changes[0]).plain_m);
      // of one who stands movements are noise, and a lag brings the views no nearer
      if (!(change.fit.after_m < kNearerShare * change.fit.before_m)) break;
      fit.changes.push_back(std::move(change));
      late.push_back(who);
      std::erase(group, who);
      if (sensors_.size() == 2) break;
    }
    if (!late.empty()) fit.groups.push_back(late);
  }

  // Puts the sensor outside that was moved farthest, though all agree in the mean.
  void find_pushed(SensorsFit& fit) const {
    Sensors& group = fit.groups.front();
    std::optional<SensorChange> farthest;
    for (const std::size_t s : group) {
      if (!(fit.apart_m[s] >= kNoPush_m)) continue;
      SensorChange change{s, {}};
      change.fit.before_m = fit.apart_m[s];
      look_for_push(mean_of(group, s), change);
      if (change.pushed_s && (!farthest || change.pushed_m > farthest->pushed_m)) farthest = change;
    }
    if (!farthest) return;
    std::erase(group, farthest->sensor);
    fit.groups.push_back({farthest->sensor});
    fit.changes.push_back(*farthest);
  }

  void look_for_push(const PointStream& others, SensorChange& change) const {
    const PointStream& view = in_world_[change.sensor];
    const StreamPair pair{others, view};
    const TimeBlocks blocks = blocks_of(pair);
    const ViewPush push = best_push(view, others);
    double without_m = mean_of_known(errors_of_change(pair, blocks, {.frame = FrameChange::turned}).judged_m);
    for (const StreamChange& found : change.fit.changes)
      without_m = std::min(without_m, judged_in_sensor_m(change.sensor, others, found));
    constexpr double kLagStep_s = 0.1;
    for (double start_s = -kLookedFor.max_start_s; start_s <= kLookedFor.max_start_s; start_s += kLagStep_s)
      without_m = std::min(
          without_m,
          mean_of_known(errors_of_change(pair, blocks, {.start_s = start_s, .has_start = true}).judged_m));
    if (!(push.judged_m < kPushedShare * without_m) || !(push.moved_m > kMinPushed_m)) return;
    change.pushed_s = push.at_s;
    change.pushed_m = push.moved_m;
    change.fit.status = StreamFitStatus::found;
    change.fit.changes.clear();
    change.fit.after_m = push.plain_m;
  }

  double judged_in_sensor_m(std::size_t sensor, const PointStream& others, const StreamChange& found) const {
    const SensorStream& s = sensors_[sensor];
    const PointStream reference = moved(others, s.world_from_sensor.inverse());
    const StreamPair pair{reference, s.in_sensor};
    return mean_of_known(errors_of_change(pair, blocks_of(pair), found).judged_m);
  }

  const std::vector<SensorStream>& sensors_;
  RigLooks looks_;
  std::vector<PointStream> in_world_;
};

}  // namespace

SensorsFit fit_sensors(const std::vector<SensorStream>& sensors,
                       const std::optional<UprightPoints>& upright) {
  if (sensors.empty()) return {};
  return SensorsFitter(sensors, upright).run();
}

}  // namespace trilat
