// SPDX-License-Identifier: MIT
// Notes on one sensor's stream of bodies: its positions, clock, frames and frame rate.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "datasets/base/median.h"
#include "pipeline/accuracy/take/take_checks.h"

namespace trilat {
namespace {

// A sensor_gap_s that fits a sensor's frames: so many times their distance, rounded up to whole steps.
constexpr double kGapsOfFrames = 1.3, kGapStep_s = 0.05;
constexpr double kHole = 2.0;  // times the median step between frames

// Mean time between a sensor's frames, longer holes left out; nothing for fewer than two frames.
std::optional<double> frame_step_s(const SensorBodies& seen) {
  std::vector<double> steps_s;
  for (std::size_t f = 1; f < seen.frames.size(); ++f)
    steps_s.push_back((seen.frames[f].time - seen.frames[f - 1].time).seconds());
  if (steps_s.empty()) return std::nullopt;
  const double most_s = kHole * upper_median(steps_s);
  std::erase_if(steps_s, [&](double step_s) { return step_s > most_s; });
  return std::accumulate(steps_s.begin(), steps_s.end(), 0.0) / static_cast<double>(steps_s.size());
}

std::vector<std::string> texts_of(const SensorBodies& seen, const SensorClockMap& clock,
                                  double sensor_gap_s) {
  std::vector<std::string> texts;
  const auto misread = seen.joints.misread_text();
  for (const auto& text :
       {seen.joints.out_of_reach_text(), misread, seen.joints.upside_down_text(), arrival_jump_text(clock)})
    if (text) texts.push_back(*text);
  if (seen.jumps > 0 && !misread)
    texts.push_back(fmt::format(
        "{} times a body moves more than 1 m from one frame to the next under one tracking id; from "
        "there it counts as another body, and the person is chosen again",
        seen.jumps));
  if (seen.stale > 0)
    texts.push_back(fmt::format(
        "{} bodies repeat the one before to the last bit under new time stamps; they count as not seen",
        seen.stale));
  if (seen.not_later > 0)
    texts.push_back(fmt::format(
        "{} frames have a time that is not after that of the frame before, and are left out: are they "
        "there twice, or was the sensor's clock set back?",
        seen.not_later));
  if (const auto step_s = frame_step_s(seen); step_s && *step_s > sensor_gap_s)
    texts.push_back(fmt::format(
        "frames are {:.2f} s apart, and sensor_gap_s is {:g} s, so that nothing is interpolated between "
        "them and most instants have no answer; set \"sensor_gap_s\": {:g} in the study",
        *step_s, sensor_gap_s, kGapStep_s * std::ceil(kGapsOfFrames * *step_s / kGapStep_s)));
  return texts;
}

}  // namespace

std::vector<TakeNote> notes_on_streams(const Plan& plan, const PlannedTake& planned, const RigBodies& seen) {
  std::vector<std::pair<std::string, std::string>> notes;  // sensors, text
  std::vector<double> backward_feet;
  for (std::size_t s = 0; s < seen.size(); ++s) {
    for (const std::string& text : texts_of(seen[s], planned.host_from_sensor[s], plan.study.sensor_gap_s)) {
      const auto same = std::ranges::find(notes, text, &std::pair<std::string, std::string>::second);
      if (same == notes.end())
        notes.emplace_back(plan.rig[s], text);
      else
        same->first += ", " + plan.rig[s];
    }
    if (const auto share = seen[s].joints.backward_feet()) backward_feet.push_back(*share);
  }
  if (const auto text = backward_feet_text(backward_feet); text && backward_feet.size() > 1)
    notes.emplace_back("all sensors", *text);
  std::vector<TakeNote> result;
  for (const auto& [sensors, text] : notes)
    result.push_back({planned.take.id, false, planned.take.session.string(), sensors + ": " + text});
  return result;
}

}  // namespace trilat
