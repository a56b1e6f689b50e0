// SPDX-License-Identifier: MIT
#include "pipeline/tracker/measure_tracker.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>

#include "evaluators/alignment/alignment.h"
#include "evaluators/metrics/error_statistics.h"
#include "evaluators/metrics/student.h"
#include "pipeline/tracker/take_view.h"

namespace trilat {
namespace {

constexpr double kBehind_rad = 2.6;       // 150 degrees
constexpr std::size_t kMostPerRig = 300;  // observations of one participant
constexpr double kFirstBack_rad = 1.0;
constexpr double kResolution_rad = 0.0175;  // of the angle at which a back is taken for the front
constexpr std::size_t kFewestSamples = 50;
constexpr double kTellsApart = 0.1;  // more gross errors of hidden joints than of visible ones

struct Variance {
  const char *name, *needs;
};
constexpr Variance kOfVariances[kVariances] = {
    {"bias_sigma_m", "needs a truth of joint centres, which markers are not"},
    {"view_bias_sigma_m", "needs sensors that look from several sides"},
    {"own_bias_sigma_m", "needs several sensors and a person who moves"},
    {"wander_sigma_m", "needs a truth, several sensors and a person who moves"},
    {"view_wander_sigma_m", "needs sensors that look from several sides and a person who moves"},
    {"own_wander_sigma_m", "needs several sensors and a person who moves"}};
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

// What some participants' sums say of one parameter, NaN where nothing, and how much data say it.
struct Told {
  double value = kNaN, information = 0.0;
};

struct Estimates {
  std::array<std::array<Told, kVariances>, kTrackerGroups> sigma_m;
  std::array<Told, kTrackerGroups> jitter_m, hidden_m;
  Told visible_share, path_m, ray_ratio, lag_s, hidden_as_tracked, back_rad, exchanged;
};

// The share of a joint below which it errs as a hidden one: that which tells gross errors from others best.
void estimate_visible_share(const std::array<std::array<double, 2>, kRays + 1>& by_share, Estimates& result) {
  if (by_share.front()[1] < kFewestSamples || by_share.back()[1] < kFewestSamples) return;
  const auto gross_of = [](const std::array<double, 2>& counts) { return counts[0] / counts[1]; };
  if (gross_of(by_share.front()) < gross_of(by_share.back()) + kTellsApart) return;  // hidden ones err alike
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t first_seen = 1; first_seen <= kRays; ++first_seen) {
    double wrong = 0.0;
    for (const bool seen : {false, true}) {
      double gross = 0.0, count = 0.0;
      for (std::size_t share = seen ? first_seen : 0; share < (seen ? kRays + 1 : first_seen); ++share) {
        gross += by_share[share][0];
        count += by_share[share][1];
      }
      wrong += gross * (1.0 - gross / count);  // squares about the mean
    }
    if (wrong >= least) continue;
    least = wrong;
    result.visible_share = {(static_cast<double>(first_seen) - 0.5) / kRays, by_share.front()[1]};
  }
}

// The back is taken for the front beyond an angle, in a share of cases.
void estimate_backs(const std::vector<std::pair<double, bool>>& backs, Estimates& result) {
  double behind = 0.0, turned = 0.0, ahead = 0.0;
  for (const auto& [off_rad, is_turned] : backs) {
    behind += off_rad > kBehind_rad ? 1.0 : 0.0;
    turned += off_rad > kBehind_rad && is_turned ? 1.0 : 0.0;
    ahead += off_rad < std::numbers::pi - kBehind_rad ? 1.0 : 0.0;
  }
  if (behind < kFewestSamples) return;
  result.exchanged = {turned / behind, behind};
  if (ahead < kFewestSamples || turned < 0.05 * behind) return;
  double least = std::numeric_limits<double>::infinity();
  for (double angle_rad = kFirstBack_rad; angle_rad < kBehind_rad; angle_rad += 0.25 * kResolution_rad) {
    double wrong = 0.0;
    for (const auto& [off_rad, is_turned] : backs)
      wrong += std::pow((is_turned ? 1.0 : 0.0) - (off_rad > angle_rad ? turned / behind : 0.0), 2);
    if (wrong < least) {
      least = wrong;
      result.back_rad = {angle_rad, behind};
    }
  }
}

Estimates estimate(std::span<const ParticipantSums* const> participants) {
  Estimates result;
  std::array<Sums, kTrackerGroups> products, increments;
  ParticipantSums all;
  for (const ParticipantSums* p : participants) {
    for (std::size_t g = 0; g < kTrackerGroups; ++g) {
      products[g] += p->products[g];
      increments[g] += p->increments[g];
      all.hidden_squares[g] += p->hidden_squares[g];
      all.hidden_count[g] += p->hidden_count[g];
      all.hidden_row[g] += p->hidden_row[g];
      all.jitter_m[g].insert(all.jitter_m[g].end(), p->jitter_m[g].begin(), p->jitter_m[g].end());
    }
    all.inferred += p->inferred;
    for (std::size_t share = 0; share <= kRays; ++share)
      for (std::size_t k = 0; k < 2; ++k) all.gross_by_share[share][k] += p->gross_by_share[share][k];
    all.hidden_joints += p->hidden_joints;
    all.along += p->along;
    all.across += p->across;
    all.rays += p->rays;
    all.with_velocity += p->with_velocity;
    all.velocities += p->velocities;
    all.accelerations += p->accelerations;
    all.backs.insert(all.backs.end(), p->backs.begin(), p->backs.end());
  }
  // The path that explains all groups best, between the candidates by a parabola.
  std::array<double, kPaths> misfit{};
  double changes = 0.0;
  for (const Sums& sums : increments) {
    changes += sums.count;
    for (std::size_t p = 0; sums.count > 0.0 && p < kPaths; ++p)
      misfit[p] += sums.count * std::log(std::max(misfit_of(sums, p), 1e-30));
  }
  const auto best = static_cast<std::size_t>(std::ranges::min_element(misfit) - misfit.begin());
  bool moves = false;
  std::array<Solution, kTrackerGroups> solutions;
  for (std::size_t g = 0; g < kTrackerGroups; ++g) {
    if (products[g].count + increments[g].count < kFewestSamples) continue;
    solutions[g] = solve(products[g], increments[g], best);
    for (int k = 0; k < kVariances; ++k)
      if (solutions[g].told[static_cast<std::size_t>(k)]) {
        result.sigma_m[g][static_cast<std::size_t>(k)] = {
            std::sqrt(solutions[g].variance_m2[k]),
            k < kParts ? information_of(products[g].normal[best], k, 0, kParts)
                       : information_of(increments[g].normal[best], k, view, kVariances)};
        moves |= k >= kParts && solutions[g].variance_m2[k] > 0.0;
      }
  }
  if (moves && best > 0 && best + 1 < kPaths) {
    const double before = misfit[best - 1], at = misfit[best], after = misfit[best + 1];
    const double shift = 0.5 * (before - after) / (before - 2.0 * at + after);
    result.path_m = {kPaths_m[best] * std::pow(kPaths_m[best + 1] / kPaths_m[best], shift), changes};
  }
  for (std::size_t g = 0; g < kTrackerGroups; ++g)
    if (const auto n = static_cast<double>(all.jitter_m[g].size()); n > 0.0)
      result.jitter_m[g] = {std::accumulate(all.jitter_m[g].begin(), all.jitter_m[g].end(), 0.0) / n, n};
  for (std::size_t g = 0; g < kTrackerGroups; ++g)
    if (const double n = all.hidden_count[g]; n >= kFewestSamples)
      result.hidden_m[g] = {
          std::sqrt(
              std::max(0.0, (all.hidden_squares[g] - all.hidden_row[g].dot(solutions[g].variance_m2)) / n)),
          n};
  if (all.hidden_joints >= kFewestSamples)
    result.hidden_as_tracked = {1.0 - all.inferred / all.hidden_joints, all.hidden_joints};
  if (all.rays >= kFewestSamples) result.ray_ratio = {std::sqrt(all.along / all.across), all.rays};
  if (all.velocities > 0.01 * kFewestSamples) {
    // A first-order filter of w rad/s errs by lag / (1 + (w lag)^2) times the speed.
    const double late_s = all.with_velocity / all.velocities;
    result.lag_s = {late_s * (1.0 + late_s * late_s * all.accelerations / all.velocities), all.velocities};
  }
  estimate_visible_share(all.gross_by_share, result);
  estimate_backs(all.backs, result);
  return result;
}

// Value and interval of one parameter from all participants and from all but each. What a participant adds to
// the information says whether they count: degrees of freedom are of so many as would say as much in equal
// parts.
std::optional<MeasuredParameter> with_interval(const Told& whole, const std::vector<Told>& without,
                                               double most, double least_half) {
  if (!std::isfinite(whole.value)) return std::nullopt;
  MeasuredParameter m{.name = {}, .group = {}, .value = whole.value};
  std::vector<double> pieces;
  double sum = 0.0, squares = 0.0;
  for (const Told& one : without) {
    const double added = whole.information - one.information;
    if (added < 0.01 * whole.information / static_cast<double>(without.size())) continue;
    sum += added;
    squares += added * added;
    ++m.participants;
    if (std::isfinite(one.value)) pieces.push_back(one.value);
  }
  const auto equal_parts = static_cast<std::size_t>(squares > 0.0 ? std::lround(sum * sum / squares) : 0);
  if (pieces.size() < 3 || pieces.size() < m.participants || equal_parts < 2) return m;
  const auto n = static_cast<double>(pieces.size());
  const double mean = std::accumulate(pieces.begin(), pieces.end(), 0.0) / n;
  double spread = 0.0;
  for (const double piece : pieces) spread += std::pow(piece - mean, 2);
  const double half =
      std::max(least_half, student_quantile(equal_parts - 1) * std::sqrt((n - 1.0) / n * spread));
  m.low = std::max(0.0, m.value - half);
  m.high = std::min(most, m.value + half);
  return m;
}

}  // namespace

std::array<double, kTrackerGroups> resting_jitter_m(std::span<const double> time_s,
                                                    std::span<const ObservedBody> bodies) {
  constexpr std::size_t kAround = 8;  // frames to each side in which a joint rests
  constexpr float kRests_m = 0.004f;
  constexpr double kMadToSigma = 1.4826;
  std::array<std::vector<double>, kTrackerGroups> changes_m;
  for (std::size_t i = kAround; i + kAround < bodies.size(); ++i) {
    const double period_s = time_s[i + 1] - time_s[i];
    if (std::abs(period_s - (time_s[i] - time_s[i - 1])) > 0.2 * period_s) continue;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const auto at = [&](std::size_t k) -> const Eigen::Vector3f& { return bodies[k].joint_in_sensor_m[j]; };
      bool rests = true;
      for (std::size_t k = i - kAround; rests && k <= i + kAround; ++k)
        rests = bodies[k].state[j] == TrackingState::tracked;
      if (!rests || (at(i + kAround) - at(i - kAround)).norm() > kRests_m) continue;
      const Eigen::Vector3f change = at(i + 1) - 2.0f * at(i) + at(i - 1);
      for (int axis = 0; axis < 3; ++axis)
        changes_m[group_of(j)].push_back(std::abs(static_cast<double>(change[axis])));
    }
  }
  std::array<double, kTrackerGroups> jitter_m;
  for (std::size_t g = 0; g < kTrackerGroups; ++g) {
    jitter_m[g] = kNaN;
    if (changes_m[g].size() < kFewestSamples) continue;
    const double most_m = 5.0 * kMadToSigma * quantiles_of(changes_m[g], {0.5})[0];  // beyond, it jumped
    double squares = 0.0, count = 0.0;
    for (const double change_m : changes_m[g])
      if (change_m <= most_m) {
        squares += change_m * change_m;
        count += 1.0;
      }
    jitter_m[g] = std::sqrt(squares / count / 6.0);
  }
  return jitter_m;
}

TrackerMeasurement measure_tracker(std::span<const WatchedTake> takes) {
  std::map<std::string, std::map<std::string, std::vector<std::size_t>>> rigs;  // of each participant
  for (std::size_t t = 0; t < takes.size(); ++t) rigs[takes[t].participant][takes[t].rig].push_back(t);
  std::vector<ParticipantSums> sums;
  for (const auto& [participant, of_rig] : rigs) {
    ParticipantSums& mine = sums.emplace_back();
    for (const auto& [rig, numbers] : of_rig) {
      std::size_t expected = 0;
      for (const std::size_t t : numbers) {
        const std::size_t sensors = takes[t].world_from_sensor.size();
        const TruthKind kind = takes[t].truth_kind;
        expected +=
            takes[t].bodies.instants() * ((kind == TruthKind::none ? 0 : sensors) +
                                          (kind == TruthKind::exact ? 0 : sensors * (sensors - 1) / 2));
      }
      const std::size_t stride = std::max<std::size_t>(1, expected / kMostPerRig);
      std::vector<Observation> together;
      for (const std::size_t t : numbers) {
        for (std::size_t g = 0; g < kTrackerGroups; ++g)
          if (std::isfinite(takes[t].jitter_m[g])) mine.jitter_m[g].push_back(takes[t].jitter_m[g]);
        std::vector<Observation> seen = observe_take(takes[t], t, stride, mine);
        if (takes[t].truth_kind == TruthKind::exact) undo_lag(takes[t], seen, mine);
        add_increments(seen, takes[t], mine);
        for (const Observation& o : seen)
          if (o.difference || takes[t].truth_kind == TruthKind::exact) together.push_back(o);
      }
      add_products(together, mine);
    }
  }
  std::vector<const ParticipantSums*> all;
  for (const ParticipantSums& one : sums) all.push_back(&one);
  const Estimates whole = estimate(all);
  std::vector<Estimates> without;
  for (std::size_t p = 0; all.size() >= 3 && p < all.size(); ++p) {
    std::vector<const ParticipantSums*> rest = all;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(p));
    without.push_back(estimate(rest));
  }

  TrackerMeasurement result;
  const auto told = [&](const char* name, std::string_view group, const auto& member_of,
                        double most = kNoLimit, double least_half = 0.0) {
    std::vector<Told> pieces;
    for (const Estimates& one : without) pieces.push_back(member_of(one));
    auto m = with_interval(member_of(whole), pieces, most, least_half);
    if (!m) return false;
    m->name = name;
    m->group = group;
    m->participants = without.empty() ? sums.size() : m->participants;
    result.measured.push_back(*m);
    return true;
  };
  const auto of_groups = [&](const char* name, const auto& told_of, const char* why) {
    bool any = false;
    for (std::size_t g = 0; g < kTrackerGroups; ++g)
      any |= told(name, name_of(static_cast<TrackerGroup>(g)),
                  [&](const Estimates& e) { return told_of(e, g); });
    if (!any) result.untold.push_back({name, why});
  };
  const auto value = [&](const char* name, Told Estimates::*estimate, double most, const char* why,
                         double least_half = 0.0) {
    if (!told(
            name, "", [&](const Estimates& e) { return e.*estimate; }, most, least_half))
      result.untold.push_back({name, why});
  };
  for (std::size_t k = 0; k < kVariances; ++k)
    of_groups(
        kOfVariances[k].name, [&](const Estimates& e, std::size_t g) { return e.sigma_m[g][k]; },
        kOfVariances[k].needs);
  of_groups(
      "jitter_sigma_m", [](const Estimates& e, std::size_t g) { return e.jitter_m[g]; },
      "needs joints that rest for half a second");
  of_groups(
      "inferred_error_sigma_m", [](const Estimates& e, std::size_t g) { return e.hidden_m[g]; },
      "needs joints that one sensor cannot see, and a truth or another sensor that sees them");
  value("wander_path_m", &Estimates::path_m, kNoLimit,
        "needs joints that move by more than their errors keep");
  value("ray_ratio", &Estimates::ray_ratio, kNoLimit,
        "needs an exact truth, or two sensors that look from one side");
  value("lag_s", &Estimates::lag_s, kNoLimit, "needs a truth whose clock was not set by the motion");
  value("least_visible_share", &Estimates::visible_share, 1.0,
        "needs joints that one sensor cannot see, and a truth or another sensor that sees them", 0.5 / kRays);
  value("hidden_as_tracked_share", &Estimates::hidden_as_tracked, 1.0, "needs tracking states and a truth");
  value("back_view_angle_rad", &Estimates::back_rad, std::numbers::pi,
        "needs a person who is seen from all sides", kResolution_rad);
  value("exchanged_share", &Estimates::exchanged, 1.0, "needs a person who is seen from behind");
  for (const char* name :
       {"jump_rate_per_minute", "jump_size_m", "jump_duration_s", "identity_changes_per_minute"})
    result.untold.push_back({name, "is not measured"});
  result.untold.push_back({"unit_depth_share", "is part of own_bias_sigma_m"});
  return result;
}

}  // namespace trilat
