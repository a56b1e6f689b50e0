// SPDX-License-Identifier: MIT
#include "pipeline/stream_fit/stream_search.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {
namespace {

constexpr double kMinTurn_rad = 0.05, kMinShift_m = 0.15, kMinDrift_s = 0.02;
constexpr std::size_t kCoarseInstants = 120, kMaxCoarseInstants = 1500;
constexpr std::size_t kKeptOfClass = 3;     // starts that are refined
constexpr std::size_t kLeading = 24;        // kinds of changes that are judged with all simpler ones
constexpr std::size_t kExchangesFrom = 10;  // leading changes in which exchanged points are looked for
constexpr double kExchangedShare = 0.6, kExchangedPoint_m = 0.10;
constexpr double kRefineStart_s = 0.02, kFinest = 1.0 / 64.0;
constexpr double kRefineRate = 0.05;  // of a logarithm, about the rate that was found

using Order = std::vector<std::size_t>;

// Indices of the lists that a change was chosen from, and the kinds of its frame and clock. Changes of one
// class differ in fitted numbers alone.
struct ChangeClass {
  std::size_t size = 0, order = 0, root = 0;
  FrameChange frame = FrameChange::none;
  bool mirrored = false, has_start = false, has_stretch = false;
  auto operator<=>(const ChangeClass&) const = default;
};

struct Candidate {
  StreamChange change;
  double rms_m = HUGE_VAL;
};

// Constant pose of each point: what is left where streams have no time in common.
std::vector<double> pose_errors_m(const PointStream& reference, const TimeBlocks& blocks) {
  std::vector<Eigen::Vector3d> mean_m(reference.points, Eigen::Vector3d::Zero());
  std::vector<double> count(reference.points, 0.0);
  for (std::size_t k = 0; k < reference.at_m.size(); ++k)
    if (reference.at_m[k].allFinite()) {
      mean_m[k % reference.points] += reference.at_m[k];
      count[k % reference.points] += 1.0;
    }
  for (std::size_t j = 0; j < reference.points; ++j) mean_m[j] /= std::max(1.0, count[j]);
  std::vector<double> errors_m(blocks.count, 0.0), pairs(blocks.count, 0.0);
  for (std::size_t k = 0; k < reference.at_m.size(); ++k) {
    if (!reference.at_m[k].allFinite()) continue;
    const double since_s = static_cast<double>(k / reference.points) / reference.rate_hz;
    const std::size_t b = std::min(blocks.count - 1, static_cast<std::size_t>(since_s / blocks.length_s));
    errors_m[b] += (reference.at_m[k] - mean_m[k % reference.points]).norm();
    pairs[b] += 1.0;
  }
  for (std::size_t b = 0; b < blocks.count; ++b) errors_m[b] = pairs[b] > 0.0 ? errors_m[b] / pairs[b] : kNaN;
  return errors_m;
}

// Root mean square of what a constant pose leaves.
double pose_rms_m(const std::vector<double>& pose_errors) {
  double sum = 0.0, count = 0.0;
  for (const double m : pose_errors)
    if (std::isfinite(m)) {
      sum += m * m;
      count += 1.0;
    }
  return count > 0.0 ? std::sqrt(sum / count) : kNaN;
}

class ChangeSearch {
 public:
  ChangeSearch(const StreamPair& pair, const TimeBlocks& blocks, const std::vector<std::size_t>& mirrored,
               const StreamFitOptions& options)
      : options_(options),
        pair_(pair),
        mirrored_(mirrored),
        blocks_(blocks),
        pose_m_(pose_errors_m(pair.reference, blocks_)),
        pose_rms_m_(pose_rms_m(pose_m_)) {
    const double both_s = std::max(0.5, std::min(pair.reference.duration_s(), pair.subject.duration_s()));
    const auto instants = static_cast<double>(pair.reference.instants());
    const double wanted = std::min(static_cast<double>(kMaxCoarseInstants),
                                   kCoarseInstants * std::max(1.0, pair.reference.duration_s() / both_s));
    coarse_step_ = std::max<std::size_t>(1, static_cast<std::size_t>(instants / wanted));
    for (std::size_t i = 0; i < pair.reference.instants(); i += coarse_step_)
      for (std::size_t j = 0; j < pair.reference.points; ++j)
        coarse_pairs_ += pair.reference.at(i, j).allFinite() ? 1.0 : 0.0;
  }

  std::vector<JudgedChange> run() {
    propose();
    judge_leading();
    return std::move(judged_);
  }

 private:
  void propose() {
    sizes_ = size_candidates(pair_);
    std::erase_if(sizes_,
                  [&](const std::vector<SizeChange>& sizes) { return !is_looked_for({.sizes = sizes}); });
    roots_.emplace_back();
    if (is_looked_for(kRootCause))
      for (const BodyRoot& root : root_candidates(pair_, mirrored_)) roots_.emplace_back(root);
    Order same(pair_.reference.points);
    std::iota(same.begin(), same.end(), 0);
    orders_.push_back(same);
    if (mirrored_ != same && is_looked_for(kSidesCause)) orders_.push_back(mirrored_);
    for (const std::vector<SizeChange>& sizes : sizes_)
      clocks_.push_back(clock_candidates(pair_, mirrored_, sizes, options_));
    for (std::size_t order = 0; order < orders_.size(); ++order) look_at_order(order);
    if (!is_looked_for(kSidesCause)) return;
    for (const Order& order : exchanges()) {
      orders_.push_back(order);
      look_at_order(orders_.size() - 1);
    }
  }

  bool is_looked_for(unsigned causes) const { return (causes & ~options_.causes) == 0; }
  bool is_looked_for(const StreamChange& change) const { return is_looked_for(causes_of(change)); }

  void look_at_order(std::size_t order) {
    for (std::size_t size = 0; size < sizes_.size(); ++size)
      for (std::size_t root = 0; root < roots_.size(); ++root)
        for (const StreamChange& clock : clocks_[size]) {
          StreamChange change = clock;
          if (order > 0) change.order = orders_[order];
          change.root = roots_[root];
          look_at(change, {.size = size, .order = order, .root = root});
        }
  }

  // Squared distances that a change leaves with each frame. A constant pose stands in where it has no point.
  template <class Visit>
  void with_each_frame(const StreamChange& change, const Visit& visit) const {
    FrameSums sums;
    ChangedPairs changed(pair_, change);
    for (std::size_t i = 0; i < pair_.reference.instants(); i += coarse_step_)
      changed.visit(i, [&](std::size_t, const Eigen::Vector3d& reference, const Eigen::Vector3d& subject) {
        sums.add(reference, subject);
      });
    constexpr double kMinShare = 0.05;  // of the pairs of the shorter stream
    if (sums.pairs < kMinShare * std::min(coarse_pairs_, shorter_pairs())) return;
    const double posed_m2 = std::max(0.0, coarse_pairs_ - sums.pairs) * pose_rms_m_ * pose_rms_m_;
    for (const FrameChange frame : {FrameChange::none, FrameChange::shifted, FrameChange::axes,
                                    FrameChange::axes_shifted, FrameChange::turned})
      for (const bool mirrored : {false, true}) {
        if (mirrored && (frame == FrameChange::none || frame == FrameChange::shifted)) continue;
        if (change.root && (frame == FrameChange::shifted || frame == FrameChange::axes_shifted)) continue;
        if (options_.any_frame ? frame != FrameChange::turned
                               : !is_looked_for({.frame = frame, .mirrored = mirrored}))
          continue;
        const double squares_m2 = fit_frame(sums, frame, mirrored).squares_m2 + posed_m2;
        visit(frame, mirrored, std::sqrt(squares_m2 / std::max(1.0, coarse_pairs_)));
      }
  }
  double shorter_pairs() const {
    return coarse_pairs_ *
           std::min(1.0, pair_.subject.duration_s() / std::max(1e-9, pair_.reference.duration_s()));
  }

  void look_at(const StreamChange& change, ChangeClass of) {
    of.has_start = change.has_start;
    of.has_stretch = change.has_stretch;
    with_each_frame(change, [&](FrameChange frame, bool mirrored, double rms_m) {
      of.frame = frame;
      of.mirrored = mirrored;
      Candidate candidate{change, rms_m};
      candidate.change.frame = frame;
      candidate.change.mirrored = mirrored;
      keep(of, std::move(candidate));
    });
    // a rate that drifts is looked for about every start, and about the stated one
    if (!change.has_stretch && of.has_start) return;
    if (!change.has_stretch && is_looked_for(kRateCause)) {
      StreamChange drifting = change;
      drifting.has_stretch = true;
      look_at(drifting, of);
    }
  }

  void keep(const ChangeClass& of, Candidate candidate) {
    std::vector<Candidate>& kept = classes_[of];
    kept.push_back(std::move(candidate));
    std::ranges::stable_sort(kept, {}, &Candidate::rms_m);
    if (kept.size() > kKeptOfClass) kept.pop_back();
  }

  // Classes by what their best change leaves.
  std::vector<std::pair<double, ChangeClass>> ranked() const {
    std::vector<std::pair<double, ChangeClass>> list;
    for (const auto& [of, kept] : classes_) list.emplace_back(kept.front().rms_m, of);
    std::ranges::sort(list);
    return list;
  }

  // Orders of points under which leading changes leave clearly less: exchanged sides, or any two points.
  std::set<Order> exchanges() const {
    std::set<Order> found;
    const auto look_at_change = [&](const StreamChange& change, const Order& order) {
      if (Order other = exchanged(change, order); std::ranges::find(orders_, other) == orders_.end())
        found.insert(std::move(other));
    };
    look_at_change(no_change(options_), orders_.front());
    std::size_t looked = 0;
    for (const auto& [rms_m, of] : ranked()) {
      if (looked++ == kExchangesFrom) break;
      look_at_change(classes_.at(of).front().change, orders_[of.order]);
    }
    return found;
  }

  Order exchanged(const StreamChange& base, Order order) const {
    const std::size_t points = order.size();
    StreamChange change = base;
    change.order.clear();
    FrameSums sums;
    std::vector<std::vector<Eigen::Vector3d>> reference, subject;  // by instant
    StreamChange ordered = base;
    ChangedPairs with_order(pair_, ordered), plain(pair_, change);
    for (std::size_t i = 0; i < pair_.reference.instants(); i += coarse_step_) {
      with_order.visit(
          i, [&](std::size_t, const Eigen::Vector3d& a, const Eigen::Vector3d& b) { sums.add(a, b); });
      reference.emplace_back(points, Eigen::Vector3d::Constant(kNaN));
      subject.emplace_back(points, Eigen::Vector3d::Constant(kNaN));
      plain.visit(i, [&](std::size_t j, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
        reference.back()[j] = a;
        subject.back()[j] = b;
      });
    }
    const FrameFit fit = fit_frame(sums, base.frame, base.mirrored);
    const auto distance_m = [&](std::size_t of_reference, std::size_t of_subject) {
      double sum = 0.0, count = 0.0;
      for (std::size_t i = 0; i < reference.size(); ++i) {
        const double m =
            (reference[i][of_reference] - fit.rotation * subject[i][of_subject] - fit.shift_m).norm();
        if (!std::isfinite(m)) continue;
        sum += m;
        count += 1.0;
      }
      return count > 0.0 ? sum / count : HUGE_VAL;
    };
    std::vector<bool> taken(points, false);
    const auto try_exchange = [&](std::size_t j, std::size_t k) {
      if (taken[j] || taken[k]) return;
      const double now_j = distance_m(j, order[j]), now_k = distance_m(k, order[k]);
      const double then_j = distance_m(j, order[k]), then_k = distance_m(k, order[j]);
      if (!(then_j + then_k < kExchangedShare * (now_j + now_k)) || !(now_j + now_k > kExchangedPoint_m))
        return;
      std::swap(order[j], order[k]);
      taken[j] = taken[k] = true;
    };
    for (std::size_t j = 0; j < points; ++j)
      if (mirrored_[j] > j) try_exchange(j, mirrored_[j]);
    for (std::size_t j = 0; j < points; ++j)
      for (std::size_t k = j + 1; k < points; ++k) try_exchange(j, k);
    // a turn that was fitted to wrong names says little of which are near
    const bool is_known = options_.any_frame || base.frame != FrameChange::turned;
    return is_known ? nearest(std::move(order), distance_m) : order;
  }

  // The order in which each point of the reference has the subject's nearest that is left, where that leaves
  // clearly less; else the same.
  template <class Distance>
  Order nearest(Order order, const Distance& distance_m) const {
    constexpr double kClearlyLess = 0.5;
    struct Match {
      double m;
      std::size_t of_reference, of_subject;
    };
    std::vector<Match> matches;
    double now_m = 0.0, then_m = 0.0;
    for (std::size_t j = 0; j < order.size(); ++j)
      for (std::size_t k = 0; k < order.size(); ++k) {
        matches.push_back({distance_m(j, k), j, k});
        if (order[j] == k) now_m += matches.back().m;
      }
    std::ranges::stable_sort(matches, {}, &Match::m);
    Order found(order.size(), order.size());
    std::vector<bool> taken(order.size(), false);
    for (const Match& match : matches) {
      if (found[match.of_reference] < order.size() || taken[match.of_subject]) continue;
      found[match.of_reference] = match.of_subject;
      taken[match.of_subject] = true;
      then_m += match.m;
    }
    const bool is_far = now_m > kExchangedPoint_m * static_cast<double>(order.size());
    return is_far && then_m < kClearlyLess * now_m ? found : order;
  }

  double rms_of(const StreamChange& change) const {
    double found = HUGE_VAL;
    with_each_frame(change, [&](FrameChange frame, bool mirrored, double rms_m) {
      if (frame == change.frame && mirrored == change.mirrored) found = rms_m;
    });
    return found;
  }

  // Start and rate that leave least, near where they are: a search along both with halved steps.
  void refine(Candidate& candidate) const {
    StreamChange& change = candidate.change;
    if (!change.has_start && !change.has_stretch) return;
    const double half_s =
        std::max(0.5, 0.5 * std::min(pair_.subject.duration_s(), pair_.reference.duration_s()));
    const auto moved = [&](double later_s, double faster) {
      StreamChange to = change;
      to.stretch += faster;
      to.start_s += later_s;
      // about the middle of the subject, unless both begin together
      if (change.has_start) to.start_s -= faster * 0.5 * pair_.subject.duration_s();
      return to;
    };
    candidate.rms_m = rms_of(change);
    const double found_stretch = change.stretch;
    for (double step = 1.0; step >= kFinest;) {
      bool better = false;
      const double step_s = step * kRefineStart_s;
      for (const auto& [later_s, faster] :
           {std::pair{step_s, 0.0}, {-step_s, 0.0}, {0.0, step_s / half_s}, {0.0, -step_s / half_s}}) {
        if ((later_s != 0.0 && !change.has_start) || (faster != 0.0 && !change.has_stretch)) continue;
        StreamChange to = moved(later_s, faster);
        // slowed down without end, a stream that stands still would be a little nearer each time
        if (!(std::abs(std::log(to.stretch / found_stretch)) < kRefineRate)) continue;
        if (const double rms_m = rms_of(to); rms_m < candidate.rms_m) {
          candidate.rms_m = rms_m;
          change = to;
          better = true;
        }
      }
      if (!better) step *= 0.5;
    }
  }

  // Whether there are blocks enough of what the shorter stream could answer.
  bool answers_enough(const ChangeErrors& errors) const {
    constexpr double kMinAnswered = 0.3;
    const auto answered = static_cast<std::size_t>(
        std::ranges::count_if(errors.judged_m, [](double m) { return std::isfinite(m); }));
    const double possible =
        static_cast<double>(blocks_.count) * shorter_pairs() / std::max(1.0, coarse_pairs_);
    return answered >= kMinJudgedBlocks && static_cast<double>(answered) >= kMinAnswered * possible;
  }

  // Whether the fitted numbers lie above the limits of what is named.
  bool is_noticed(const StreamChange& change) const {
    if (change.has_start && std::abs(change.start_s) < options_.min_start_s && !change.has_stretch)
      return false;
    if (change.has_stretch && std::abs(change.stretch - 1.0) * 0.5 * pair_.subject.duration_s() < kMinDrift_s)
      return false;
    if (change.frame == FrameChange::shifted && change.shift_m.norm() < kMinShift_m) return false;
    return change.frame != FrameChange::turned || change.mirrored || options_.any_frame ||
           (change.root && change.root->turns) ||
           std::acos(std::clamp(0.5 * (change.rotation.trace() - 1.0), -1.0, 1.0)) > kMinTurn_rad;
  }

  void judge(const ChangeClass& of) {
    if (!judged_classes_.insert(of).second) return;
    const auto found = classes_.find(of);
    if (found == classes_.end()) return;
    for (Candidate& candidate : found->second) {
      refine(candidate);
      StreamChange change = fitted(pair_, blocks_, candidate.change);
      const unsigned causes = named_causes(change, options_);
      // a cause by itself that is too small to be named still explains more simply than several
      const bool noticed = is_noticed(change);
      if (!noticed && std::popcount(causes) > 1) continue;
      JudgedChange judged{change, causes, parameters_of(change), errors_of_change(pair_, blocks_, change)};
      judged.is_noticed = noticed;
      if (answers_enough(judged.errors)) judged_.push_back(std::move(judged));
    }
  }

  // The leading classes, and each with some of its causes taken away.
  void judge_leading() {
    if (is_looked_for(kRateCause)) add_drifting_starts();
    const StreamChange unchanged = fitted(pair_, blocks_, no_change(options_));
    judged_classes_.insert(ChangeClass{.frame = unchanged.frame});
    // no change comes first
    judged_.push_back({unchanged, 0, parameters_of(unchanged), errors_of_change(pair_, blocks_, unchanged)});
    std::size_t count = 0;
    for (const auto& [rms_m, of] : ranked()) {
      if (count++ == kLeading) break;
      for (const std::size_t size : std::set<std::size_t>{0, of.size})
        for (const std::size_t order : std::set<std::size_t>{0, of.order})
          for (const std::size_t root : std::set<std::size_t>{0, of.root})
            for (const FrameChange frame :
                 options_.any_frame ? std::vector{of.frame} : simpler_frames(of.frame))
              for (const bool mirrored : std::set<bool>{false, of.mirrored})
                for (const bool has_start : std::set<bool>{false, of.has_start})
                  for (const bool has_stretch : std::set<bool>{false, of.has_stretch})
                    judge({size, order, root, frame, mirrored, has_start, has_stretch});
    }
    for (std::size_t b = 0; b < blocks_.count; ++b) {
      double most = 0.0;
      for (const JudgedChange& judged : judged_) most = std::max(most, judged.errors.pairs[b]);
      // where a change leaves nothing to compare, it is as good as a constant pose, and no better than none
      const double unchanged_m = judged_.front().errors.judged_m[b];
      const double unanswered_m = std::isnan(unchanged_m) ? pose_m_[b] : std::max(pose_m_[b], unchanged_m);
      constexpr double kAnswered = 0.2;
      for (JudgedChange& judged : judged_) {
        double& error_m = judged.errors.judged_m[b];
        if (most > 0.0 && (std::isnan(error_m) || judged.errors.pairs[b] < kAnswered * most))
          error_m = unanswered_m;
        if (most == 0.0) error_m = kNaN;
      }
    }
    for (JudgedChange& judged : judged_) judged.mean_m = mean_of_known(judged.errors.judged_m);
    std::erase_if(judged_, [](const JudgedChange& judged) { return std::isnan(judged.mean_m); });
  }

  // Leading starts also with a rate of their own.
  void add_drifting_starts() {
    std::vector<std::pair<ChangeClass, Candidate>> more;
    std::size_t count = 0;
    for (const auto& [rms_m, of] : ranked()) {
      if (!of.has_start || of.has_stretch) continue;
      if (count++ == kLeading) break;
      ChangeClass drifting = of;
      drifting.has_stretch = true;
      Candidate candidate = classes_.at(of).front();
      candidate.change.has_stretch = true;
      more.emplace_back(drifting, std::move(candidate));
    }
    for (auto& [of, candidate] : more) keep(of, std::move(candidate));
  }

  static std::vector<FrameChange> simpler_frames(FrameChange frame) {
    switch (frame) {
      case FrameChange::none:
        return {FrameChange::none};
      case FrameChange::shifted:
        return {FrameChange::none, FrameChange::shifted};
      case FrameChange::axes:
        return {FrameChange::none, FrameChange::axes};
      case FrameChange::axes_shifted:
        return {FrameChange::none, FrameChange::shifted, FrameChange::axes, FrameChange::axes_shifted};
      case FrameChange::turned:
        return {FrameChange::none, FrameChange::shifted, FrameChange::axes, FrameChange::axes_shifted,
                FrameChange::turned};
    }
    return {frame};
  }

  StreamFitOptions options_;
  const StreamPair& pair_;
  const std::vector<std::size_t>& mirrored_;
  TimeBlocks blocks_;
  std::vector<double> pose_m_;
  double pose_rms_m_ = 0.0, coarse_pairs_ = 0.0;
  std::size_t coarse_step_ = 1;
  std::vector<std::vector<SizeChange>> sizes_;
  std::vector<std::optional<BodyRoot>> roots_;
  std::vector<Order> orders_;
  std::vector<std::vector<StreamChange>> clocks_;  // by size
  std::map<ChangeClass, std::vector<Candidate>> classes_;
  std::set<ChangeClass> judged_classes_;
  std::vector<JudgedChange> judged_;
};

}  // namespace

std::vector<JudgedChange> search_changes(const StreamPair& pair, const TimeBlocks& blocks,
                                         const std::vector<std::size_t>& mirrored,
                                         const StreamFitOptions& options) {
  return ChangeSearch(pair, blocks, mirrored, options).run();
}

}  // namespace trilat
