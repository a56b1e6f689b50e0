// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/median.h"
#include "evaluators/alignment/clock_offset.h"
#include "pipeline/accuracy/brought/brought_joints.h"
#include "pipeline/accuracy/take/truth_track.h"

namespace trilat {
namespace {

constexpr std::size_t kMostLooks = 400;  // instants that are compared
constexpr double kClearlyBetter = 0.5;   // of the error without a change
constexpr double kLeastError_m = 0.03;   // what is closer needs no explanation
constexpr double kMostLeft_m = 0.15;     // of the error, where the axes explain it
constexpr double kNoticed_s = 0.02;      // of a start
constexpr double kHoles = 0.05;          // of the instants
constexpr double kShort_s = 0.5;

// The instants at which both have a point: pairs of truth and what was brought.
struct Pairs {
  std::vector<Eigen::Vector3d> truth_m, brought_m;
};

// `pace`: of the brought times, about the file's first frame; `later_s`: by which they are moved.
Pairs pairs_of(const Plan& plan, const PointPath* truth, const BroughtTrack& brought, double pace = 1.0,
               double later_s = 0.0, std::size_t looks = kMostLooks) {
  Pairs pairs;
  std::vector<Eigen::Vector3d> points(plan.names.size());
  const std::size_t step = std::max<std::size_t>(1, truth->time_s.size() / looks);
  for (std::size_t i = 0; i < truth->time_s.size(); i += step) {
    points_at(brought, brought.first_s + (truth->time_s[i] - brought.first_s) * pace - later_s, points);
    for (std::size_t j = 0; j < points.size(); ++j)
      if (points[j].allFinite() && truth[j].position_m[i].allFinite()) {
        pairs.truth_m.push_back(truth[j].position_m[i]);
        pairs.brought_m.push_back(points[j]);
      }
  }
  return pairs;
}

Eigen::Vector3d mean_of(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) sum += point;
  return sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

double spread_m(const std::vector<Eigen::Vector3d>& points) {
  const Eigen::Vector3d mean = mean_of(points);
  double sum = 0.0;
  for (const Eigen::Vector3d& point : points) sum += (point - mean).squaredNorm();
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, points.size())));
}

// Mean distance with the means laid over each other, the brought points turned first.
double distance_m(const Pairs& pairs, const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity()) {
  if (pairs.truth_m.empty()) return kNaN;
  const Eigen::Vector3d shift = mean_of(pairs.truth_m) - turn * mean_of(pairs.brought_m);
  double sum = 0.0;
  for (std::size_t k = 0; k < pairs.truth_m.size(); ++k)
    sum += (turn * pairs.brought_m[k] + shift - pairs.truth_m[k]).norm();
  return sum / static_cast<double>(pairs.truth_m.size());
}

// Reports a spread of the points that a wrong unit would explain.
std::optional<std::string> unit_text(const Pairs& pairs) {
  constexpr std::pair<double, const char*> kUnits[] = {
      {1000.0, "millimetres read as metres"},    {100.0, "centimetres read as metres"},
      {10.0, "millimetres read as centimetres"}, {0.1, "centimetres read as millimetres"},
      {0.01, "metres read as centimetres"},      {0.001, "metres read as millimetres"},
      {39.37, "inches read as metres"},          {3.281, "feet read as metres"},
      {0.0254, "metres read as inches"}};
  if (spread_m(pairs.truth_m) < kLeastError_m) return std::nullopt;  // one point that stands still
  const double ratio = spread_m(pairs.brought_m) / spread_m(pairs.truth_m);
  if (!(ratio > 0.0) || (ratio > 0.6 && ratio < 1.7)) return std::nullopt;
  for (const auto& [factor, what] : kUnits)
    if (std::abs(std::log(ratio / factor)) < 0.2)
      return fmt::format("lies {:.4g} times as far apart as the truth does: {}? Mend the unit in the file",
                         ratio, what);
  return fmt::format(
      "lies {:.3g} times as far apart as the truth does; are the joints the same, and the unit right?",
      ratio);
}

std::string axes_text(const Eigen::Matrix3d& turn) {
  std::string text;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      if (turn(row, column) != 0.0)
        text += fmt::format("{}{}{}", text.empty() ? "" : ", ", turn(row, column) < 0.0 ? "-" : "",
                            "xyz"[column]);
  return text;
}

// Reports axes that are exchanged or mirrored, when exchanging them back makes the error clearly smaller.
std::optional<std::string> turn_text(const Pairs& pairs) {
  const double now_m = distance_m(pairs);
  if (!(now_m > kLeastError_m)) return std::nullopt;
  double best_m = now_m;
  Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
      for (int row = 0; row < 3; ++row)
        turn(row, order.at(static_cast<std::size_t>(row))) = (signs >> row & 1) != 0 ? -1.0 : 1.0;
      if (const double m = distance_m(pairs, turn); m < best_m) {
        best_m = m;
        best = turn;
      }
    }
  } while (std::ranges::next_permutation(order).found);
  if (best_m > std::min(kClearlyBetter * now_m, kMostLeft_m)) return std::nullopt;
  return fmt::format(
      "has other axes than the truth: read as ({}), its mean distance from it falls from {:.1f} to {:.1f} "
      "cm. Write its x, y, z so",
      axes_text(best), 100.0 * now_m, 100.0 * best_m);
}

// Reports a wrong rate, when another rate makes the error clearly smaller.
std::optional<std::string> pace_text(const Plan& plan, const PointPath* truth, const BroughtTrack& brought) {
  const double now_m = distance_m(pairs_of(plan, truth, brought));
  if (!(now_m > kLeastError_m)) return std::nullopt;
  for (const double pace : {0.5, 2.0, 0.25, 4.0, 25.0 / 30.0, 30.0 / 25.0, 100.0 / 120.0, 120.0 / 100.0}) {
    const Pairs pairs = pairs_of(plan, truth, brought, pace);
    if (pairs.truth_m.size() < kMostLooks / 8 || distance_m(pairs) > kClearlyBetter * now_m) continue;
    return fmt::format(
        "runs {:.3g} times as fast as the truth: at its rate times {:.3g} its mean distance falls from "
        "{:.1f} to {:.1f} cm. Mend the rate or the times in the file",
        1.0 / pace, pace, 100.0 * now_m, 100.0 * distance_m(pairs));
  }
  return std::nullopt;
}

// Reports a file that begins late or ends early, and positions that are missing in between.
std::vector<std::string> hole_texts(const Plan& plan, const PointPath* truth, const BroughtTrack& brought) {
  std::vector<std::string> texts;
  const double begins_s = brought.first_s + brought.offset_s,
               ends_s = begins_s + 1e-9 * static_cast<double>(brought.track.end().ns),
               last_s = truth->time_s.back();
  if (begins_s > kShort_s || ends_s < last_s - kShort_s)
    texts.push_back(
        fmt::format("holds {:.2f} to {:.2f} s of 0 to {:.2f} s; what is outside counts against its coverage",
                    begins_s, ends_s, last_s));
  std::size_t asked = 0, missing = 0;
  std::vector<Eigen::Vector3d> points(plan.names.size());
  const std::size_t step = std::max<std::size_t>(1, truth->time_s.size() / kMostLooks);
  for (std::size_t i = 0; i < truth->time_s.size(); i += step) {
    if (truth->time_s[i] < begins_s || truth->time_s[i] > ends_s) continue;
    points_at(brought, truth->time_s[i], points);
    for (std::size_t j = 0; j < points.size(); ++j) {
      if (!truth[j].position_m[i].allFinite()) continue;
      ++asked;
      missing += points[j].allFinite() ? 0 : 1;
    }
  }
  if (static_cast<double>(missing) > kHoles * static_cast<double>(asked))
    texts.push_back(fmt::format("has no position for {:.0f} % of what is asked for within its time",
                                100.0 * static_cast<double>(missing) / static_cast<double>(asked)));
  return texts;
}

ClockOffset offset_of(const Plan& plan, const PointPath* truth, const BroughtTrack& brought) {
  constexpr std::size_t kEnough = 8;  // points, spread over all
  std::vector<PointPath> paths(plan.names.size());
  std::vector<Eigen::Vector3d> points(plan.names.size());
  for (const double t : truth->time_s) {
    points_at(brought, t, points);
    for (std::size_t j = 0; j < points.size(); ++j) {
      paths[j].time_s.push_back(t);
      paths[j].position_m.push_back(points[j]);
    }
  }
  std::vector<PointPath> some_truth, some;
  const std::size_t step = (paths.size() + kEnough - 1) / kEnough;
  for (std::size_t j = 0; j < paths.size(); j += step) {
    some_truth.push_back(truth[j]);
    some.push_back(std::move(paths[j]));
  }
  ClockOffsetOptions options;
  options.search_s = plan.study.clock_search_s;
  options.grid_hz = 120.0;
  options.frames = StreamFrames::turned;
  return find_clock_offset(std::move(some), some_truth, options);
}

// Where the speeds do not tell: the start that lays the positions best over the truth's, if it does so
// clearly better than the one that is stated. Both are in one frame.
std::optional<double> best_start_s(const Plan& plan, const PointPath* truth, const BroughtTrack& brought) {
  constexpr std::size_t kLooks = 60;
  constexpr double kStep_s = 0.02;
  const double now_m = distance_m(pairs_of(plan, truth, brought, 1.0, 0.0, kLooks));
  if (!(now_m > kLeastError_m)) return std::nullopt;
  double best_m = std::min(kClearlyBetter * now_m, kMostLeft_m);
  std::optional<double> best_s;
  for (double later_s = -plan.study.clock_search_s; later_s <= plan.study.clock_search_s;
       later_s += kStep_s) {
    const Pairs pairs = pairs_of(plan, truth, brought, 1.0, later_s, kLooks);
    const double m = distance_m(pairs);
    if (pairs.truth_m.size() < kLooks * plan.names.size() / 4 || !(m < best_m)) continue;
    best_m = m;
    best_s = later_s;
  }
  return best_s;
}

// Reports the offset of the clock that the motion shows; nothing when it is under 20 ms or unknown.
std::optional<std::string> clock_text(const ClockOffset& found, const BroughtTrack& brought) {
  if (found.status == ClockOffsetStatus::no_agreement || found.status == ClockOffsetStatus::at_limit)
    return "does not move as the truth moves, at any start that was looked at; is it the same take, and the "
           "same person?";
  if (found.status != ClockOffsetStatus::found || std::abs(found.offset_s) < kNoticed_s) return std::nullopt;
  return fmt::format("starts {:.3f} s ({:.3f} to {:.3f}) {} than the truth, by the motion. {}",
                     std::abs(found.offset_s), std::min(std::abs(found.low_s), std::abs(found.high_s)),
                     std::max(std::abs(found.low_s), std::abs(found.high_s)),
                     found.offset_s > 0.0 ? "earlier" : "later",
                     brought.joints->clock_by_motion
                         ? std::string("That was applied")
                         : fmt::format("At the mean speed of {:.2f} m/s that makes errors of {:.0f} cm; mend "
                                       "its times, or say \"clock\": \"motion\" beside the file",
                                       found.speed_m_s, 100.0 * std::abs(found.offset_s) * found.speed_m_s));
}

}  // namespace

std::vector<TakeNote> check_brought(const Plan& plan, const PlannedTake& planned, const PointPath* truth,
                                    BroughtTrack& brought) {
  std::vector<TakeNote> notes;
  const auto note = [&](std::string text) {
    notes.push_back({planned.take.id, false, brought.joints->file.string(), std::move(text)});
  };
  for (std::string& text : oddities_of(brought.track)) note(std::move(text));
  if (!brought.left_out.empty() && plan.rig.empty())
    note(fmt::format(
        "has {} names that are not compared, since the truth has none of them: {}", brought.left_out.size(),
        fmt::join(std::span(brought.left_out).first(std::min<std::size_t>(8, brought.left_out.size())),
                  ", ")));
  const Pairs pairs = pairs_of(plan, truth, brought);
  std::optional<std::string> cause = unit_text(pairs);
  if (!cause) cause = turn_text(pairs);
  if (!cause) cause = pace_text(plan, truth, brought);
  if (!cause) {
    const ClockOffset found = offset_of(plan, truth, brought);
    cause = clock_text(found, brought);
    if (found.status != ClockOffsetStatus::found)
      if (const auto later_s = best_start_s(plan, truth, brought))
        cause = fmt::format(
            "starts about {:.2f} s {} than the truth: moved so, it lies at most half as far from it. Mend "
            "its times",
            std::abs(*later_s), *later_s > 0.0 ? "earlier" : "later");
    if (brought.joints->clock_by_motion && found.status == ClockOffsetStatus::found)
      brought.offset_s = found.offset_s;
    else if (brought.joints->clock_by_motion && !cause)
      cause = "keeps its own times, since the motion does not say when it starts: " +
              cause_of(std::string(name_of(found.status)));
  }
  constexpr double kFar_m = 0.5;
  if (const double far_m = distance_m(pairs); !cause && far_m > kFar_m)
    cause = fmt::format(
        "lies {:.0f} cm from the truth in the mean, also with their means laid over each other; is it the "
        "same take, and the same person?",
        100.0 * far_m);
  if (cause) note(std::move(*cause));
  for (std::string& text : hole_texts(plan, truth, brought)) note(std::move(text));
  return notes;
}

}  // namespace trilat
