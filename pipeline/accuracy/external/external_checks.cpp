// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

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
            ? ""
            : fmt::format("; no frame follows that of {:.2f} s for {:.2f} s",
                          begins_s + (*gap - MocapTime{}).seconds(), (gap[1] - gap[0]).seconds())));
  return texts;
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
  std::optional<ClockJump> jump;
  std::optional<PartChange> part;
  if (fit.status == StreamFitStatus::unexplained) {
    jump = find_clock_jump({reference, subject}, mirrored, options, fit.before_m);
    part = find_part_change({reference, subject}, mirrored, options, fit.before_m);
    if (jump && part) (jump->after_m <= part->after_m ? part.reset() : jump.reset());
  }
  const bool shows_start = fit.status == StreamFitStatus::found && fit.changes.front().has_start &&
                           !fit.changes.front().has_stretch;
  const bool is_applied = shows_start && external.joints->clock_by_motion;
  if (is_applied) external.offset_s = fit.changes.front().start_s;
  const StreamWords words{.names = plan.names, .clock_is_applied = is_applied};
  note(jump   ? jump_note(*jump, fit.before_m, words)
       : part ? part_note(*part, fit.before_m, words)
              : stream_note(fit, words));
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
