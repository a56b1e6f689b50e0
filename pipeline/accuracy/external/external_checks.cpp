// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "pipeline/accuracy/external/external_joints.h"
#include "pipeline/stream_fit/stream_words.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxStreamInstants = 20'000;
constexpr std::size_t kMaxLooks = 400;  // instants at which holes are counted
constexpr double kHoles = 0.05;         // of the instants
constexpr double kShort_s = 0.5;

// The truth at the take's instants.
PointStream truth_stream(const Plan& plan, const PointPath* truth) {
  const std::vector<double>& since_s = truth->time_s;
  const std::size_t step = 1 + since_s.size() / kMaxStreamInstants;
  PointStream stream{since_s.front(), plan.study.rate_hz / static_cast<double>(step), plan.names.size(), {}};
  for (std::size_t i = 0; i < since_s.size(); i += step)
    for (std::size_t j = 0; j < plan.names.size(); ++j) stream.at_m.push_back(truth[j].position_m[i]);
  return stream;
}

// External joints at their own rate.
PointStream external_stream(const Plan& plan, const ExternalTrack& external) {
  const double duration_s = (external.track.end() - MocapTime{}).seconds();
  const auto frames = static_cast<double>(external.track.positions().time.size());
  const double intervals = std::clamp(frames - 1.0, 1.0, static_cast<double>(kMaxStreamInstants));
  PointStream stream{external.first_s,
                     duration_s > 0.0 ? intervals / duration_s : plan.study.rate_hz,
                     plan.names.size(),
                     {}};
  std::vector<Eigen::Vector3d> points(plan.names.size());
  for (double k = 0.0; k <= intervals; k += 1.0) {
    points_at(external, std::min(external.first_s + k / stream.rate_hz, external.first_s + duration_s),
              points);
    stream.at_m.insert(stream.at_m.end(), points.begin(), points.end());
  }
  return stream;
}

// The text on time stamps that come in bursts; empty where they do not.
std::string burst_text(const std::vector<MocapTime>& time) {
  constexpr double kInBurst = 0.2;  // of the mean step
  if (time.size() < 3) return {};
  std::vector<double> steps_s;
  for (std::size_t k = 1; k < time.size(); ++k) steps_s.push_back((time[k] - time[k - 1]).seconds());
  const double mean_s = (time.back() - time.front()).seconds() / static_cast<double>(steps_s.size());
  const double median_s = upper_median(std::move(steps_s));
  if (!(median_s < kInBurst * mean_s)) return {};
  return fmt::format(
      "; its times come in bursts (half of its steps are {:.3g} ms, at {:.3g} ms in the mean): are they "
      "stamps of arrival? Write when each frame was taken",
      1e3 * median_s, 1e3 * mean_s);
}

// Reports a file that begins late or ends early, and positions that are missing in between.
std::vector<std::string> hole_texts(const Plan& plan, const PointPath* truth, const ExternalTrack& external) {
  std::vector<std::string> texts;
  const double begins_s = external.first_s + external.offset_s,
               ends_s = begins_s + (external.track.end() - MocapTime{}).seconds(),
               last_s = truth->time_s.back();
  if (begins_s > kShort_s || ends_s < last_s - kShort_s)
    texts.push_back(
        fmt::format("holds {:.2f} to {:.2f} s of 0 to {:.2f} s; what is outside counts against its coverage",
                    begins_s, ends_s, last_s));
  std::size_t asked = 0, missing = 0;
  std::vector<Eigen::Vector3d> points(plan.names.size());
  const std::size_t step = std::max<std::size_t>(1, truth->time_s.size() / kMaxLooks);
  for (std::size_t i = 0; i < truth->time_s.size(); i += step) {
    if (truth->time_s[i] < begins_s || truth->time_s[i] > ends_s) continue;
    points_at(external, truth->time_s[i], points);
    for (std::size_t j = 0; j < points.size(); ++j) {
      if (!truth[j].position_m[i].allFinite()) continue;
      ++asked;
      missing += points[j].allFinite() ? 0 : 1;
    }
  }
  const std::vector<MocapTime>& time = external.track.positions().time;
  const auto gap = std::ranges::adjacent_find(
      time, [](MocapTime one, MocapTime next) { return next - one >= duration_from_s(kShort_s); });
  if (static_cast<double>(missing) > kHoles * static_cast<double>(asked))
    texts.push_back(fmt::format(
        "has no position for {:.0f} % of what is asked for within its time{}",
        100.0 * static_cast<double>(missing) / static_cast<double>(asked),
        gap == time.end()
            ? burst_text(time)
            : fmt::format("; no frame follows that of {:.2f} s for {:.2f} s",
                          begins_s + (*gap - MocapTime{}).seconds(), (gap[1] - gap[0]).seconds())));
  return texts;
}

// Points that the subject has at one place, and the reference has not.
std::vector<std::string> copy_texts(const StreamPair& pair, const std::vector<std::string>& names) {
  constexpr double kMinInstants = 10.0, kAlmostAll = 0.9;
  const auto share_equal = [](const PointStream& stream, std::size_t one, std::size_t other) {
    double known = 0.0, equal = 0.0;
    for (std::size_t i = 0; i < stream.instants(); ++i) {
      if (!stream.at(i, one).allFinite() || !stream.at(i, other).allFinite()) continue;
      known += 1.0;
      equal += stream.at(i, one) == stream.at(i, other) ? 1.0 : 0.0;
      if (known >= kMinInstants && equal < kAlmostAll * known) break;
    }
    return known < kMinInstants ? 0.0 : equal / known;
  };
  std::vector<std::string> texts;
  for (std::size_t one = 0; one < names.size(); ++one)
    for (std::size_t other = one + 1; other < names.size(); ++other)
      if (share_equal(pair.subject, one, other) > kAlmostAll &&
          share_equal(pair.reference, one, other) <= kAlmostAll)
        texts.push_back(
            fmt::format("has {} and {} at one place to the last digit; was one copied for the other?",
                        names[one], names[other]));
  return texts;
}

struct Distance {
  double m, when_s;
};

// Distances between the streams by point, with the change that was found.
std::vector<std::vector<Distance>> distances_of(const StreamPair& pair, const StreamFit& fit) {
  const StreamChange change = fit.changes.empty() ? StreamChange{} : fit.changes.front();
  std::vector<std::vector<Distance>> all(pair.reference.points);
  ChangedPairs pairs(pair, change);
  for (std::size_t i = 0; i < pair.reference.instants(); ++i)
    pairs.visit(i, [&](std::size_t j, const Eigen::Vector3d& reference, const Eigen::Vector3d& subject) {
      all[j].push_back(
          {(reference - change.rotation * subject - change.shift_m).norm(), pair.reference.time_s(i)});
    });
  return all;
}

double median_m(const std::vector<Distance>& distances) {
  if (distances.empty()) return kNaN;
  std::vector<double> all_m;
  for (const Distance& distance : distances) all_m.push_back(distance.m);
  return upper_median(std::move(all_m));
}

// Median distance of a point of the subject from one of the reference, with a change and so much later.
double point_m(const StreamPair& pair, const StreamChange& change, std::size_t of_subject,
               std::size_t of_reference, double later_s) {
  constexpr std::size_t kMaxInstants = 400;
  StreamChange moved = change;
  moved.start_s -= later_s;
  moved.order.clear();
  std::vector<double> all_m;
  ChangedPairs pairs(pair, moved);
  const std::size_t step = 1 + pair.reference.instants() / kMaxInstants;
  for (std::size_t i = 0; i < pair.reference.instants(); i += step) {
    Eigen::Vector3d reference_m = Eigen::Vector3d::Constant(kNaN), subject_m = reference_m;
    pairs.visit(i, [&](std::size_t j, const Eigen::Vector3d& reference, const Eigen::Vector3d& subject) {
      if (j == of_reference) reference_m = reference;
      if (j == of_subject) subject_m = subject;
    });
    if (const double m = (reference_m - change.rotation * subject_m - change.shift_m).norm();
        std::isfinite(m))
      all_m.push_back(m);
  }
  return all_m.empty() ? kNaN : upper_median(std::move(all_m));
}

// Why one point is so far off: it is another one, or late. Empty where that is not known.
std::string point_cause(const StreamPair& pair, const StreamChange& change, std::size_t point, double off_m,
                        const std::vector<std::string>& names) {
  constexpr double kExplained = 0.4, kStep_s = 0.05, kMaxLate_s = 0.5;
  double least_m = kExplained * off_m;
  const std::size_t of_subject = change.order.empty() ? point : change.order[point];
  std::string text;
  const auto try_as = [&](std::size_t of_reference, double later_s, const auto& text_of) {
    const double m = point_m(pair, change, of_subject, of_reference, later_s);
    if (!(m < least_m)) return;
    least_m = m;
    text = fmt::format("{}: {:.0f} cm", text_of(), kCentimetresPerMetre * m);
  };
  for (std::size_t other = 0; other < names.size(); ++other)
    if (other != point) try_as(other, 0.0, [&] { return fmt::format(" (where {} is", names[other]); });
  for (double late_s = kStep_s; late_s < kMaxLate_s + kStep_s / 2.0; late_s += kStep_s)
    for (const double later_s : {late_s, -late_s})
      try_as(point, later_s, [&] {
        return fmt::format(" ({:.2f} s {} than the others", late_s, later_s > 0.0 ? "later" : "earlier");
      });
  return text.empty() ? text : text + ")";
}

// Points that lie much farther off than the others.
std::string point_text(const StreamPair& pair, const std::vector<std::vector<Distance>>& distances,
                       const StreamFit& fit, const std::vector<std::string>& names) {
  constexpr double kMinOff_m = 0.2, kTimes = 4.0, kMinCausedOff_m = 0.08, kCausedTimes = 2.0;
  constexpr double kSound_m = 0.1;  // of half the points, where the others are all that is wrong
  constexpr std::size_t kMinPoints = 4;
  std::vector<double> of_point_m, known_m;
  for (const std::vector<Distance>& of_point : distances) of_point_m.push_back(median_m(of_point));
  std::ranges::copy_if(of_point_m, std::back_inserter(known_m), [](double m) { return std::isfinite(m); });
  if (known_m.size() < kMinPoints) return {};
  const double half_m = upper_median(known_m);
  if (fit.status == StreamFitStatus::unexplained && (half_m > kSound_m || !fit.changes.empty())) return {};
  const StreamChange change = fit.changes.empty() ? StreamChange{} : fit.changes.front();
  std::vector<std::string> far;
  bool is_explained = true;
  for (std::size_t j = 0; j < names.size(); ++j) {
    if (!(of_point_m[j] > std::max(kMinCausedOff_m, kCausedTimes * half_m))) continue;
    const std::string cause = point_cause(pair, change, j, of_point_m[j], names);
    if (cause.empty() && !(of_point_m[j] > std::max(kMinOff_m, kTimes * half_m))) continue;
    is_explained &= !cause.empty();
    far.push_back(fmt::format("{} {:.0f} cm{}", names[j], kCentimetresPerMetre * of_point_m[j], cause));
  }
  if (far.empty()) return {};
  return fmt::format("has {} from the truth{}, and half of its points less than {:.1f} cm{}",
                     fmt::join(far, ", "), fit.changes.empty() ? "" : " when it is put right",
                     kCentimetresPerMetre * half_m,
                     is_explained ? "" : "; does the name stand for another point, or are its axes others?");
}

// Few positions that make much of the mean error.
std::string outlier_text(const std::vector<std::vector<Distance>>& distances) {
  constexpr double kFar_m = 1.0, kTimes = 10.0, kMaxShare = 0.1, kMinPart = 0.2;
  constexpr std::size_t kMinPositions = 100;
  std::vector<Distance> all;
  for (const std::vector<Distance>& of_point : distances)
    all.insert(all.end(), of_point.begin(), of_point.end());
  if (all.size() < kMinPositions) return {};
  const double half_m = median_m(all), far_m = std::max(kFar_m, kTimes * half_m);
  double sum_m = 0.0, far_sum_m = 0.0, far = 0.0, first_s = HUGE_VAL;
  for (const auto& [m, when_s] : all) {
    sum_m += m;
    if (m < far_m) continue;
    first_s = std::min(first_s, when_s);
    far_sum_m += m;
    far += 1.0;
  }
  const auto count = static_cast<double>(all.size());
  if (far == 0.0 || far > kMaxShare * count || far_sum_m < kMinPart * sum_m) return {};
  return fmt::format(
      "has {:.1f} % of its positions more than {:.0f} cm from the truth, first at {:.2f} s, and half of all "
      "less than {:.1f} cm: these few make {:.0f} % of the mean error",
      100.0 * far / count, kCentimetresPerMetre * far_m, first_s, kCentimetresPerMetre * half_m,
      100.0 * far_sum_m / sum_m);
}

// Whether the distance is much larger in some blocks of time than in others.
bool is_uneven(const StreamFit& fit) {
  constexpr double kTimes = 2.0, kMinWorst_m = 0.1;
  std::vector<double> known_m;
  std::ranges::copy_if(fit.of_block_m, std::back_inserter(known_m),
                       [](double m) { return std::isfinite(m); });
  if (known_m.size() < kMinJudgedBlocks) return false;
  std::ranges::sort(known_m);
  const double best_m = known_m[known_m.size() / 6],
               worst_m = known_m[known_m.size() - 1 - known_m.size() / 6];
  return worst_m > std::max(kMinWorst_m, kTimes * best_m);
}

// The note on what changes as time goes on, where no one change explains the difference; the fit's own else.
std::string fit_text(const StreamPair& pair, const std::vector<std::size_t>& mirrored,
                     const StreamFitOptions& options, const StreamFit& fit, const StreamWords& words) {
  const bool is_unexplained = fit.status == StreamFitStatus::unexplained;
  if (fit.status == StreamFitStatus::found &&
      (causes_of(fit.changes.front()) & ~unsigned{kShiftCause | kTurnCause}) == 0)
    if (const auto drift = find_frame_drift(pair)) return drift_note(*drift, fit.before_m, words);
  if (!is_unexplained && !(fit.status == StreamFitStatus::sound && is_uneven(fit)))
    return stream_note(fit, words);
  if (is_unexplained)
    if (const auto after_m = find_own_places(pair, fit.before_m))
      return own_places_note(*after_m, fit.before_m, words);
  const auto jump = is_unexplained ? find_clock_jump(pair, mirrored, options, fit.before_m) : std::nullopt;
  const double most_left_m = fit.before_m / (is_unexplained ? 3.0 : 2.0);
  const auto part = find_part_change(pair, mirrored, options, most_left_m);
  const auto drift = find_frame_drift(pair);
  const double jump_m = jump ? jump->after_m : HUGE_VAL, part_m = part ? part->after_m : HUGE_VAL;
  constexpr double kClearly = 0.7;  // a drift has a frame for each piece
  if (drift && drift->after_m < kClearly * std::min(jump_m, part_m))
    return drift_note(*drift, fit.before_m, words);
  if (jump && jump_m <= part_m) return jump_note(*jump, fit.before_m, words);
  return part ? part_note(*part, fit.before_m, words) : stream_note(fit, words);
}

}  // namespace

std::vector<TakeNote> check_external(const Plan& plan, const PlannedTake& planned, const PointPath* truth,
                                     ExternalTrack& external) {
  std::vector<TakeNote> notes;
  const auto note = [&](std::string text) {
    if (!text.empty())
      notes.push_back({planned.take.id, false, external.joints->file.string(), std::move(text)});
  };
  for (std::string& text : suspicious_names(external.track)) note(std::move(text));
  if (!external.left_out.empty() && plan.rig.empty())
    note(fmt::format(
        "has {} names that are not compared, since the truth has none of them: {}", external.left_out.size(),
        fmt::join(std::span(external.left_out).first(std::min<std::size_t>(8, external.left_out.size())),
                  ", ")));
  const PointStream reference = truth_stream(plan, truth), subject = external_stream(plan, external);
  // what is made of a recording's bodies has the trackers' lag, some 0.05 s
  constexpr double kMinStart_s = 0.02, kMinStartOfBodies_s = 0.07;
  const std::vector<std::size_t> mirrored = mirrored_points(plan.names);
  const StreamFitOptions options{.min_start_s = plan.rig.empty() ? kMinStart_s : kMinStartOfBodies_s};
  const StreamFit fit = fit_streams({reference, subject}, mirrored, options);
  const bool shows_start = fit.status == StreamFitStatus::found && fit.changes.front().has_start &&
                           !fit.changes.front().has_stretch;
  const bool is_applied = shows_start && external.joints->clock_by_motion;
  if (is_applied) external.offset_s = fit.changes.front().start_s;
  const StreamWords words{.names = plan.names, .clock_is_applied = is_applied};
  const auto distances = distances_of({reference, subject}, fit);
  const std::string points = point_text({reference, subject}, distances, fit, plan.names);
  if (points.empty() || fit.status != StreamFitStatus::unexplained)
    note(fit_text({reference, subject}, mirrored, options, fit, words));
  for (std::string& text : copy_texts({reference, subject}, plan.names)) note(std::move(text));
  note(points);
  if (fit.status == StreamFitStatus::sound && points.empty()) note(outlier_text(distances));
  if (external.joints->clock_by_motion && !shows_start && fit.status != StreamFitStatus::sound)
    note("keeps its own times, since the motion does not say when it starts");
  if (fit.overlap_s <= 0.0 && fit.status != StreamFitStatus::found)
    note(
        "has no time in common with the truth; --clock-by-motion, or \"clock\": \"motion\" beside the file, "
        "looks "
        "for the start that its motion shows");
  for (std::string& text : hole_texts(plan, truth, external)) note(std::move(text));
  return notes;
}

}  // namespace trilat
