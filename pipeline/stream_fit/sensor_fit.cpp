// SPDX-License-Identifier: MIT
#include "pipeline/stream_fit/sensor_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "datasets/base/median.h"
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
constexpr std::size_t kMaxLooks = 100;    // instants at which whole rigs are compared
constexpr std::size_t kMinPairs = 100;    // points of two sensors; fewer decide nothing
constexpr std::size_t kMaxAllOrders = 5;  // sensors of which every order of poses is tried
constexpr double kExplainedShare = 0.5;   // of the distances that a change of all may leave
constexpr double kMinDistances = 0.04;    // of a scale
constexpr double kPushedShare = 0.7, kMinPushed_m = 0.15;
constexpr std::size_t kMinBlocksBesidePush = 3;
constexpr double kUpsideDown_m = -0.3;
constexpr double kSound_m = 0.05;  // mean distance between sensors below which no change of all is looked for
constexpr double kMovement_s = 0.1;                  // to both sides
constexpr double kMaxLag_s = 1.0, kMinLag_s = 0.08;  // by movements
constexpr double kSureLag_s = 0.05;                  // less its uncertainty, a lag is larger
constexpr double kLagTimes = 1.03;                   // so much more is left without the lag
constexpr double kMinLagDuration_s = 6.0;            // in less a few steps agree at several lags
constexpr std::size_t kMinLagBlocks = 6, kMaxLagLooks = 3000;

using Sensors = std::vector<std::size_t>;

PointStream moved(const PointStream& stream, const RigidTransform& by) {
  PointStream result = stream;
  for (Eigen::Vector3d& at_m : result.at_m) at_m = by * at_m;
  return result;
}

std::vector<std::size_t> same_order(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

class SensorsFitter {
 public:
  SensorsFitter(const std::vector<SensorStream>& sensors, const std::optional<UprightPoints>& upright)
      : sensors_(sensors), upright_(upright) {
    for (const SensorStream& s : sensors) in_world_.push_back(moved(s.in_sensor, s.world_from_sensor));
    const PointStream& first = sensors.front().in_sensor;
    const std::size_t step = std::max<std::size_t>(1, first.instants() / kMaxLooks);
    looks_.resize(sensors.size());
    for (std::size_t s = 0; s < sensors.size(); ++s)
      for (std::size_t i = 0; i < first.instants(); i += step)
        for (std::size_t j = 0; j < first.points; ++j) looks_[s].push_back(sensors[s].in_sensor.at(i, j));
  }

  SensorsFit run() {
    SensorsFit fit;
    fit.groups = groups_as_stated();
    const RigChange as_stated{same_order(sensors_.size())};
    fit.before_m = fit.after_m = distance_of(as_stated);
    fit.height_m = height_of(as_stated);
    if (fit.groups.size() > 1 || fit.height_m < kUpsideDown_m || fit.before_m > kSound_m) {
      fit.rig = change_of_all(fit);
      if (fit.rig) {
        fit.after_m = distance_of(*fit.rig);
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
      sees[a] = std::ranges::any_of(looks_[a], [](const Eigen::Vector3d& p) { return p.allFinite(); });
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
  // by a single cause that is no pose.
  static bool is_named(const StreamFit& fit, double apart_m) {
    if (apart_m >= kSensorsAgree_m) return true;
    if (fit.status != StreamFitStatus::found) return false;
    const unsigned causes = causes_of(fit.changes.front());
    return causes == kStartCause || causes == kSizeCause || (causes & kMirrorCause) != 0;
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

  // Of changes that explain as much, the one with the fewest parameters: that a pose turns just as a person
  // walks about a circle, or is shifted just along the rays, would be chance.
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

  // Mean distance between two sensors, over all pairs, where the rig is changed.
  double distance_of(const RigChange& change) const {
    std::vector<std::vector<Eigen::Vector3d>> placed(sensors_.size());
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      const RigidTransform& pose = sensors_[change.pose_of[s]].world_from_sensor;
      const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix() * change.axes;
      const Eigen::Vector3d position_m = pose.translation_m / change.distances;
      for (const Eigen::Vector3d& at_m : looks_[s]) placed[s].push_back(rotation * at_m + position_m);
    }
    double sum_m = 0.0, pairs = 0.0;
    std::vector<double> distances_m;
    for (std::size_t a = 0; a < placed.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        distances_m.clear();
        for (std::size_t k = 0; k < placed[a].size(); ++k)
          if (const double m = (placed[a][k] - placed[b][k]).norm(); std::isfinite(m))
            distances_m.push_back(m);
        if (distances_m.size() < kMinPairs) continue;
        sum_m += median(distances_m);
        pairs += 1.0;
      }
    return pairs > 0.0 ? sum_m / pairs : kNaN;
  }

  // How far the high point is above the low one in the mean; NaN where nothing says so.
  double height_of(const RigChange& change) const {
    if (!upright_) return kNaN;
    const std::size_t points = sensors_.front().in_sensor.points;
    double sum_m = 0.0, count = 0.0;
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      const RigidTransform& pose = sensors_[change.pose_of[s]].world_from_sensor;
      for (std::size_t k = 0; k < looks_[s].size(); k += points) {
        const Eigen::Vector3d between_m = looks_[s][k + upright_->high] - looks_[s][k + upright_->low];
        if (!between_m.allFinite()) continue;
        sum_m += (pose.rotation * (change.axes * between_m)).y();
        count += 1.0;
      }
    }
    return sum_m / count;
  }

  // The change of all sensors that explains most, if one does; of a person who is upside down one that leaves
  // them upright.
  std::optional<RigChange> change_of_all(const SensorsFit& fit) const {
    std::optional<RigChange> best;
    const bool is_upside_down = fit.height_m < kUpsideDown_m;
    constexpr double kNoWorse = 1.1;
    double least_m = (is_upside_down && fit.groups.size() == 1 ? kNoWorse : kExplainedShare) * fit.before_m;
    // a later one must leave clearly less
    constexpr double kClearly = 0.8;
    const auto look_at = [&](const RigChange& change) {
      const double height_m = height_of(change);
      if (is_upside_down ? !(height_m > -kUpsideDown_m) : height_m < kUpsideDown_m) return;
      const double left_m = distance_of(change);
      if (!(left_m < kSensorsAgree_m) || !(left_m < (best ? kClearly : 1.0) * least_m)) return;
      best = change;
      least_m = left_m;
    };
    const std::vector<std::size_t> same = same_order(sensors_.size());
    for (const Eigen::Matrix3d& axes : axes_of_all()) look_at({same, axes});
    for (const std::vector<std::size_t>& order : orders_of_poses()) look_at({order});
    if (const RigChange scaled{same, Eigen::Matrix3d::Identity(), best_distances()};
        std::abs(std::log(scaled.distances)) > std::log1p(kMinDistances))
      look_at(scaled);
    return best;
  }

  // Those that change one sign first: other axes agree as well where all sensors stand level.
  static std::vector<Eigen::Matrix3d> axes_of_all() {
    std::vector<Eigen::Matrix3d> list;
    for (const int axis : {0, 1}) {
      list.emplace_back(Eigen::Matrix3d::Identity());
      list.back()(axis, axis) = -1.0;
    }
    std::array<int, 3> order{0, 1, 2};
    do {
      for (unsigned signs = 0; signs < 8; ++signs) {
        Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
        for (int row = 0; row < 3; ++row)
          axes(row, order.at(static_cast<std::size_t>(row))) = (signs >> row & 1U) != 0 ? -1.0 : 1.0;
        if (!axes.isIdentity()) list.push_back(axes);
      }
    } while (std::ranges::next_permutation(order).found);
    return list;
  }

  // Orders of the poses: of few sensors all, of more those that exchange two or pass three on in a circle.
  std::vector<std::vector<std::size_t>> orders_of_poses() const {
    const std::size_t count = sensors_.size();
    std::vector<std::vector<std::size_t>> orders;
    std::vector<std::size_t> order = same_order(count);
    if (count <= kMaxAllOrders) {
      while (std::ranges::next_permutation(order).found) orders.push_back(order);
      // those that move fewest first
      std::ranges::stable_sort(orders, {}, [](const std::vector<std::size_t>& o) {
        std::size_t moved = 0;
        for (std::size_t s = 0; s < o.size(); ++s) moved += o[s] == s ? 0 : 1;
        return moved;
      });
      return orders;
    }
    for (std::size_t a = 0; a < count; ++a)
      for (std::size_t b = 0; b < count; ++b)
        for (std::size_t c = 0; c < count; ++c) {
          if (a == b || a == c || b < a || c < a || (b == c && b < a)) continue;
          order = same_order(count);
          order[a] = b;
          order[b] = c == b ? a : c;
          if (c != b) order[c] = a;
          orders.push_back(order);
        }
    return orders;
  }

  // The scale of the distances between sensors under which they agree best: units of length, then near 1.
  double best_distances() const {
    constexpr std::array kFactors{1000.0, 100.0, 10.0, 0.1, 0.01, 0.001};
    const auto distance_m = [&](double factor) {
      return distance_of({same_order(sensors_.size()), Eigen::Matrix3d::Identity(), factor});
    };
    double best = 1.0, least_m = distance_m(1.0);
    const auto look_at = [&](double factor) {
      if (const double m = distance_m(factor); m < least_m) {
        least_m = m;
        best = factor;
      }
    };
    for (const double factor : kFactors) look_at(factor);
    for (double factor = 0.5; factor < 2.0; factor *= 1.04) look_at(factor);
    for (double step = 0.02; step > 0.001; step *= 0.5)
      for (const double factor : {best * (1.0 + step), best / (1.0 + step)}) look_at(factor);
    return best;
  }

  // Of two sensors, which are as likely, the one whose change explains more.
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
          outside.push_back(s);
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

  // How far points move about each instant: whatever is constant or slow in two trackers is not in it.
  static PointStream movements_of(const PointStream& stream) {
    const auto reach =
        static_cast<std::size_t>(std::max(1LL, std::llround(kMovement_s * stream.rate_hz))) * stream.points;
    PointStream moves = stream;
    for (std::size_t k = 0; k < moves.at_m.size(); ++k) {
      moves.at_m[k].setConstant(kNaN);
      if (k >= reach && k + reach < moves.at_m.size())
        moves.at_m[k] = stream.at_m[k + reach] - stream.at_m[k - reach];
    }
    return moves;
  }

  // Lag of a view behind others at which their movements agree best, with its standard deviation by a
  // jackknife over blocks of time; NaN where no lag within the search is the best for all of them, or the
  // movements agree nearly as well without.
  struct Lag {
    double lag_s = kNaN, sigma_s = kNaN;
  };
  static Lag lag_of(const PointStream& view, const PointStream& others) {
    const PointStream moves = movements_of(view), of_others = movements_of(others);
    const StreamPair pair{of_others, moves};
    TimeBlocks blocks = blocks_of(pair);
    if (blocks.count < kMinLagBlocks || of_others.duration_s() < kMinLagDuration_s) return {};
    blocks.step = 1 + of_others.instants() / kMaxLagLooks;
    const auto reach = static_cast<std::ptrdiff_t>(std::floor(kMaxLag_s * view.rate_hz));
    std::vector<std::vector<double>> left;  // by lag and block
    for (std::ptrdiff_t lag = -reach; lag <= reach; ++lag) {
      const StreamChange late{.start_s = -static_cast<double>(lag) / view.rate_hz, .has_start = true};
      left.push_back(errors_of_change(pair, blocks, late).judged_m);
    }
    const auto best_without = [&](std::size_t without) {
      std::vector<double> mean;
      for (const std::vector<double>& of_lag : left) {
        std::vector<double> kept = of_lag;
        if (without < kept.size()) kept[without] = kNaN;
        mean.push_back(mean_of_known(kept));
      }
      const auto k = static_cast<std::size_t>(std::ranges::min_element(mean) - mean.begin());
      if (k == 0 || k + 1 == mean.size() || mean[static_cast<std::size_t>(reach)] < kLagTimes * mean[k])
        return kNaN;
      const double below = mean[k - 1], above = mean[k + 1];
      const double between = 0.5 * (below - above) / (below - 2.0 * mean[k] + above);
      return (static_cast<double>(k) - static_cast<double>(reach) + between) / view.rate_hz;
    };
    Lag lag{best_without(blocks.count), 0.0};
    for (std::size_t b = 0; b < blocks.count; ++b) lag.sigma_s += std::pow(best_without(b) - lag.lag_s, 2);
    const auto n = static_cast<double>(blocks.count);
    lag.sigma_s = std::sqrt((n - 1.0) / n * lag.sigma_s);
    return lag;
  }

  // Of sensors that agree in the mean, those whose movements are late; the latest first, and each explains
  // what others seem to be early by.
  void find_late(SensorsFit& fit) const {
    Sensors& group = fit.groups.front();
    Sensors late;
    while (group.size() > 1) {
      std::size_t who = sensors_.size();
      double most_s = kMinLag_s;
      bool is_late = false;
      for (const std::size_t s : group) {
        const Lag lag = lag_of(in_world_[s], mean_of(group, s));
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
      fit.changes.push_back(std::move(change));
      late.push_back(who);
      std::erase(group, who);
      if (sensors_.size() == 2) break;
    }
    if (!late.empty()) fit.groups.push_back(late);
  }

  // Of sensors that agree in the mean, the one that was moved farthest is put outside.
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

  // Errors of two poses, one until a time and one from then on, by blocks.
  struct Push {
    double at_s = 0.0, moved_m = 0.0, judged_m = HUGE_VAL, plain_m = HUGE_VAL;
  };
  Push push_at(const PointStream& others, const PointStream& view, double at_s) const {
    Push push{at_s, 0.0, 0.0, 0.0};
    std::array<StreamChange, 2> poses;
    double blocks_known = 0.0;
    Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
    double count = 0.0;
    for (const bool is_after : {false, true}) {
      PointStream part = view;
      for (std::size_t k = 0; k < part.at_m.size(); ++k)
        if ((part.time_s(k / part.points) >= at_s) != is_after) part.at_m[k].setConstant(kNaN);
      const StreamPair pair{others, part};
      const TimeBlocks blocks = blocks_of(pair);
      const StreamChange turned{.frame = FrameChange::turned};
      const ChangeErrors errors = errors_of_change(pair, blocks, turned);
      poses.at(is_after ? 1 : 0) = fitted(pair, blocks, turned);
      for (std::size_t b = 0; b < blocks.count; ++b)
        if (std::isfinite(errors.judged_m[b])) {
          push.judged_m += errors.judged_m[b];
          push.plain_m += errors.plain_m[b];
          blocks_known += 1.0;
        }
      for (const Eigen::Vector3d& at_m : part.at_m)
        if (at_m.allFinite()) {
          middle_m += at_m;
          count += 1.0;
        }
    }
    push.judged_m /= blocks_known;
    push.plain_m /= blocks_known;
    middle_m /= count;
    push.moved_m =
        (poses[1].rotation * middle_m + poses[1].shift_m - poses[0].rotation * middle_m - poses[0].shift_m)
            .norm();
    return push;
  }

  void look_for_push(const PointStream& others, SensorChange& change) const {
    const PointStream& view = in_world_[change.sensor];
    const StreamPair pair{others, view};
    const TimeBlocks blocks = blocks_of(pair);
    Push best;
    for (std::size_t b = kMinBlocksBesidePush; b + kMinBlocksBesidePush <= blocks.count; ++b)
      if (const Push push = push_at(others, view, view.first_s + static_cast<double>(b) * blocks.length_s);
          push.judged_m < best.judged_m)
        best = push;
    double without_m = mean_of_known(errors_of_change(pair, blocks, {.frame = FrameChange::turned}).judged_m);
    for (const StreamChange& found : change.fit.changes)
      without_m = std::min(without_m, judged_in_sensor_m(change.sensor, others, found));
    constexpr double kLagStep_s = 0.1;
    for (double start_s = -kLookedFor.max_start_s; start_s <= kLookedFor.max_start_s; start_s += kLagStep_s)
      without_m = std::min(
          without_m,
          mean_of_known(errors_of_change(pair, blocks, {.start_s = start_s, .has_start = true}).judged_m));
    if (!(best.judged_m < kPushedShare * without_m) || !(best.moved_m > kMinPushed_m)) return;
    change.pushed_s = best.at_s;
    change.pushed_m = best.moved_m;
    change.fit.status = StreamFitStatus::found;
    change.fit.changes.clear();
    change.fit.after_m = best.plain_m;
  }

  double judged_in_sensor_m(std::size_t sensor, const PointStream& others, const StreamChange& found) const {
    const SensorStream& s = sensors_[sensor];
    const PointStream reference = moved(others, s.world_from_sensor.inverse());
    const StreamPair pair{reference, s.in_sensor};
    return mean_of_known(errors_of_change(pair, blocks_of(pair), found).judged_m);
  }

  const std::vector<SensorStream>& sensors_;
  std::optional<UprightPoints> upright_;
  std::vector<PointStream> in_world_;
  std::vector<std::vector<Eigen::Vector3d>> looks_;  // by sensor: points at some instants, in its frame
};

}  // namespace

SensorsFit fit_sensors(const std::vector<SensorStream>& sensors,
                       const std::optional<UprightPoints>& upright) {
  if (sensors.empty()) return {};
  return SensorsFitter(sensors, upright).run();
}

}  // namespace trilat
