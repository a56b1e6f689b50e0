// SPDX-License-Identifier: MIT
#include "pipeline/stream_fit/stream_jump.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "datasets/base/units.h"

namespace trilat {
namespace {

constexpr double kMinPairsOfPiece = 20.0;
constexpr double kUnknown_m = 0.2;  // counts for an instant of the subject that the reference does not have

// Mean distances over the points, by instant of the subject, with its times later by `start_s`; NaN where the
// subject has no points.
std::vector<double> distances_m(const StreamPair& pair, double start_s) {
  std::vector<double> all_m;
  std::vector<Eigen::Vector3d> points_m(pair.reference.points);
  for (std::size_t i = 0; i < pair.subject.instants(); ++i) {
    pair.reference.at_time(pair.subject.time_s(i) + start_s, points_m);
    double sum_m = 0.0, count = 0.0;
    bool has_points = false;
    for (std::size_t j = 0; j < points_m.size(); ++j) {
      has_points |= pair.subject.at(i, j).allFinite();
      if (const double m = (pair.subject.at(i, j) - points_m[j]).norm(); std::isfinite(m)) {
        sum_m += m;
        count += 1.0;
      }
    }
    all_m.push_back(count > 0.0 ? sum_m / count : has_points ? kUnknown_m : kNaN);
  }
  return all_m;
}

// The fit of a part of the subject, which differs in nothing but these causes.
StreamFit fit_of_part(const StreamPair& pair, std::size_t first, std::size_t end,
                      const std::vector<std::size_t>& mirrored, StreamFitOptions options, unsigned causes) {
  const PointStream& subject = pair.subject;
  const auto at = [&](std::size_t instant) {
    return subject.at_m.begin() + static_cast<std::ptrdiff_t>(instant * subject.points);
  };
  const PointStream part{subject.time_s(first), subject.rate_hz, subject.points, {at(first), at(end)}};
  options.causes = causes;
  return fit_streams({pair.reference, part}, mirrored, options);
}

double start_of_part(const StreamPair& pair, std::size_t first, std::size_t end,
                     const std::vector<std::size_t>& mirrored, const StreamFitOptions& options) {
  const StreamFit fit = fit_of_part(pair, first, end, mirrored, options, kStartCause);
  return fit.changes.empty() ? 0.0 : fit.changes.front().start_s;
}

// Where to go over from one explanation to another, whose distances by instant are these: the first instant
// of the other, and the mean distance that is left. NaN where nothing is known.
std::pair<std::size_t, double> least_between(const std::vector<double>& one_m,
                                             const std::vector<double>& other_m) {
  const auto known_m = [](double m) { return std::isnan(m) ? 0.0 : m; };
  double sum_m = 0.0, instants = 0.0, least_m = HUGE_VAL;
  for (const double m : other_m) {
    sum_m += known_m(m);
    instants += std::isnan(m) ? 0.0 : 1.0;
  }
  std::size_t first_of_other = 0;
  for (std::size_t i = 0; i < one_m.size(); ++i) {
    if (sum_m < least_m) {
      least_m = sum_m;
      first_of_other = i;
    }
    sum_m += known_m(one_m[i]) - known_m(other_m[i]);
  }
  return {first_of_other, least_m / instants};
}

// The jump from one start to another that leaves the least distance.
ClockJump jump_between(const StreamPair& pair, double start_s, double later_start_s) {
  const auto [first_after, after_m] =
      least_between(distances_m(pair, start_s), distances_m(pair, later_start_s));
  return {pair.subject.time_s(first_after), start_s, later_start_s - start_s, after_m};
}

// Mean distances over the points with a change, by instant of the reference; NaN where one of both has none.
std::vector<double> distances_with(const StreamPair& pair, const StreamChange& change) {
  ChangedPairs pairs(pair, change);
  std::vector<double> all_m;
  for (std::size_t i = 0; i < pair.reference.instants(); ++i) {
    double sum_m = 0.0, count = 0.0;
    pairs.visit(i, [&](std::size_t, const Eigen::Vector3d& reference, const Eigen::Vector3d& subject) {
      sum_m += (reference - change.rotation * subject - change.shift_m).norm();
      count += 1.0;
    });
    all_m.push_back(count > 0.0 ? sum_m / count : kNaN);
  }
  return all_m;
}

constexpr std::array kSplits{0.5, 0.25, 0.75, 0.15, 0.85};
constexpr double kExplained = 1.0 / 3.0;

// Both streams in one block of time, every second instant apart.
struct Piece {
  std::array<FrameSums, 2> sums;
  std::array<std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>>, 2> points_m;  // reference, subject
};

std::vector<Piece> pieces_of(const StreamPair& pair, const TimeBlocks& blocks) {
  std::vector<Piece> pieces(blocks.count);
  const StreamChange none;
  ChangedPairs pairs(pair, none);
  for (std::size_t i = 0; i < pair.reference.instants(); i += blocks.step) {
    const double since_s = pair.reference.time_s(i) - pair.reference.first_s;
    Piece& piece = pieces[std::min(blocks.count - 1, static_cast<std::size_t>(since_s / blocks.length_s))];
    const std::size_t half = i / blocks.step % 2;
    pairs.visit(i, [&](std::size_t, const Eigen::Vector3d& reference, const Eigen::Vector3d& subject) {
      piece.sums.at(half).add(reference, subject);
      piece.points_m.at(half).emplace_back(reference, subject);
    });
  }
  std::erase_if(pieces, [](const Piece& piece) {
    return piece.sums[0].pairs < kMinPairsOfPiece || piece.sums[1].pairs < kMinPairsOfPiece;
  });
  return pieces;
}

// Mean distance of a piece's points of one half with a frame.
double left_m(const Piece& piece, std::size_t half, const FrameFit& frame) {
  double sum_m = 0.0;
  for (const auto& [reference, subject] : piece.points_m.at(half))
    sum_m += (reference - frame.rotation * subject - frame.shift_m).norm();
  return sum_m / piece.sums.at(half).pairs;
}

}  // namespace

std::optional<ClockJump> find_clock_jump(const StreamPair& pair, const std::vector<std::size_t>& mirrored,
                                         const StreamFitOptions& options, double before_m) {
  std::optional<ClockJump> best;
  const auto instants = static_cast<double>(pair.subject.instants());
  for (const double split : kSplits) {
    const auto middle = static_cast<std::size_t>(split * instants);
    const double start_s = start_of_part(pair, 0, middle, mirrored, options),
                 later_start_s = start_of_part(pair, middle, pair.subject.instants(), mirrored, options);
    if (std::abs(later_start_s - start_s) < options.min_start_s) continue;
    const ClockJump jump = jump_between(pair, start_s, later_start_s);
    if (jump.after_m < kExplained * (best ? 3.0 * best->after_m : before_m)) best = jump;
  }
  return best;
}

std::optional<PartChange> find_part_change(const StreamPair& pair, const std::vector<std::size_t>& mirrored,
                                           const StreamFitOptions& options, double most_left_m) {
  const unsigned causes = kAllStreamCauses & ~unsigned{kStartCause | kRateCause | kLaterSizeCause};
  const std::size_t instants = pair.subject.instants();
  const std::vector<double> plain_m = distances_with(pair, no_change(options));
  std::optional<PartChange> best;
  for (const double split : kSplits) {
    const auto middle = static_cast<std::size_t>(split * static_cast<double>(instants));
    for (const bool is_later : {true, false}) {
      const StreamFit fit =
          fit_of_part(pair, is_later ? middle : 0, is_later ? instants : middle, mirrored, options, causes);
      if (fit.status != StreamFitStatus::found) continue;
      const StreamChange& change = fit.changes.front();
      const std::vector<double> changed_m = distances_with(pair, change);
      const auto [at, after_m] =
          is_later ? least_between(plain_m, changed_m) : least_between(changed_m, plain_m);
      if (after_m < (best ? best->after_m : most_left_m))
        best = PartChange{change, is_later, pair.reference.time_s(at), after_m};
    }
  }
  return best;
}

std::optional<double> find_own_places(const StreamPair& pair, double before_m) {
  constexpr double kMaxLeft_m = 0.1, kOfMovement = 0.5;
  struct Place {
    std::vector<Eigen::Vector3d> reference_m, subject_m;
  };
  std::vector<Place> places(pair.reference.points);
  const StreamChange none;
  ChangedPairs pairs(pair, none);
  for (std::size_t i = 0; i < pair.reference.instants(); ++i)
    pairs.visit(i, [&](std::size_t j, const Eigen::Vector3d& reference, const Eigen::Vector3d& subject) {
      places[j].reference_m.push_back(reference);
      places[j].subject_m.push_back(subject);
    });
  double count = 0.0, after_m = 0.0, moves_m = 0.0;
  for (const Place& place : places) {
    const std::size_t instants = place.reference_m.size();
    Eigen::Vector3d of_reference_m = Eigen::Vector3d::Zero(), of_subject_m = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < instants; ++i) {
      of_reference_m += place.reference_m[i] / static_cast<double>(instants);
      of_subject_m += place.subject_m[i] / static_cast<double>(instants);
    }
    for (std::size_t i = 0; i < instants; ++i) {
      const Eigen::Vector3d moved_m = place.reference_m[i] - of_reference_m;
      moves_m += moved_m.norm();
      after_m += (moved_m - place.subject_m[i] + of_subject_m).norm();
      count += 1.0;
    }
  }
  after_m /= count;
  moves_m /= count;
  if (!(after_m < std::min({kExplained * before_m, kMaxLeft_m, kOfMovement * moves_m}))) return std::nullopt;
  return after_m;
}

std::optional<FrameDrift> find_frame_drift(const StreamPair& pair) {
  constexpr double kExplainedDrift = 0.6, kMinGain_m = 0.025, kMaxLeft_m = 0.08;
  const TimeBlocks blocks = blocks_of(pair);
  const std::vector<Piece> pieces = pieces_of(pair, blocks);
  if (pieces.size() < kMinJudgedBlocks) return std::nullopt;
  FrameSums all;
  for (const Piece& piece : pieces) all.add(piece.sums[0]);
  const FrameFit one = fit_frame(all, FrameChange::turned, false);
  double one_m = 0.0, own_m = 0.0;
  for (const Piece& piece : pieces) {
    one_m += left_m(piece, 1, one) / static_cast<double>(pieces.size());
    own_m += left_m(piece, 1, fit_frame(piece.sums[0], FrameChange::turned, false)) /
             static_cast<double>(pieces.size());
  }
  if (!(own_m < std::min({kExplainedDrift * one_m, one_m - kMinGain_m, kMaxLeft_m}))) return std::nullopt;
  const FrameFit first = fit_frame(pieces.front().sums[0], FrameChange::turned, false),
                 last = fit_frame(pieces.back().sums[0], FrameChange::turned, false);
  const FrameSums& end = pieces.back().sums[0];
  const Eigen::Vector3d centre_m = end.of_subject_m / end.pairs;
  const Eigen::Vector3d moved_m =
      last.rotation * centre_m + last.shift_m - first.rotation * centre_m - first.shift_m;
  return FrameDrift{moved_m.norm(),
                    Eigen::AngleAxisd(Eigen::Matrix3d(last.rotation * first.rotation.transpose())).angle(),
                    blocks.length_s, own_m};
}

}  // namespace trilat
