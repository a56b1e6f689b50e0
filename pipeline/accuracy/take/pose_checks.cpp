// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "pipeline/accuracy/take/take_checks.h"
#include "pipeline/accuracy/take/take_rays.h"

namespace trilat {
namespace {

// A note names what lies with its interval beyond these and beyond what the calibration states. Trackers that
// see a person from one side err alike in all joints, by so much in takes of few seconds.
constexpr double kNoticedTurn_rad = 0.05, kNoticed_m = 0.05, kStatedSigmas = 3.0;

std::string stated_text(double sigma, const char* unit) {
  return sigma > 0.0 ? fmt::format("{:.1f} {}", sigma, unit) : std::string("no uncertainty");
}

class PoseChecker {
 public:
  PoseChecker(const Plan& plan, const PlannedTake& planned, const PreparedTake& data)
      : plan_(plan), planned_(planned), data_(data) {}

  TakeChecks run() {
    if (!data_.shown.problem.empty()) {
      if (estimates_calibration(plan_))
        note("is taken as it is: the bodies tell nothing of it, since " + data_.shown.problem);
      return std::move(checks_);
    }
    for (std::size_t s = 0; s < data_.shown.of_sensor.size(); ++s) check(s);
    return std::move(checks_);
  }

 private:
  void check(std::size_t s) {
    const SensorPose& stated = planned_.poses[s];
    const CorrectionMagnitudes shown = magnitudes_of(data_.shown, s);
    const std::string& name = plan_.rig[s];
    if (add(s, "turned", "rad", shown.rotation_rad,
            std::max(kNoticedTurn_rad, kStatedSigmas * stated.rotation_sigma_rad)))
      note(fmt::format("{} is turned by {} degrees according to the bodies; the calibration states {}", name,
                       text_of(shown.rotation_rad, kDegreesPerRad),
                       stated_text(kDegreesPerRad * stated.rotation_sigma_rad, "degrees")));
    if (add(s, "shifted", "m", shown.translation_m,
            std::max(kNoticed_m, kStatedSigmas * stated.position_sigma_m)))
      note(fmt::format("{} is {} cm away according to the bodies; the calibration states {}", name,
                       text_of(shown.translation_m, kCentimetresPerMetre),
                       stated_text(kCentimetresPerMetre * stated.position_sigma_m, "cm")));
    if (add(s, "ranges too long", "m", shown.range_m, kNoticed_m))
      note(fmt::format("{} measures {} cm too {} by the bodies", name,
                       text_of(shown.range_m, kCentimetresPerMetre),
                       shown.range_m.value > 0.0 ? "far" : "near"));
  }

  // Whether a note is due: the interval lies beyond the limit, and no note of check_sensors() explains it.
  bool add(std::size_t s, const char* what, const char* unit, const Interval& m, double limit) {
    CheckRow row{planned_.take.id, plan_.rig[s], what, unit, m.value, m.low, m.high, limit};
    row.beyond = std::max(m.low, -m.high) > limit;
    checks_.rows.push_back(row);
    return row.beyond && !data_.explained_by_sensor_check;
  }
  // "4.0 (3.1 to 4.9)", without a sign.
  static std::string text_of(const Interval& m, double factor) {
    const double low = m.value > 0.0 ? m.low : -m.high, high = m.value > 0.0 ? m.high : -m.low;
    return fmt::format("{:.1f} ({:.1f} to {:.1f})", factor * std::abs(m.value), factor * low, factor * high);
  }
  void note(std::string text) {
    checks_.notes.push_back({planned_.take.id, false, planned_.take.calibration.string(), std::move(text)});
  }

  const Plan& plan_;
  const PlannedTake& planned_;
  const PreparedTake& data_;
  TakeChecks checks_;
};

}  // namespace

TakeChecks check_poses(const Plan& plan, const PlannedTake& planned, const PreparedTake& data) {
  return PoseChecker(plan, planned, data).run();
}

std::vector<CheckRow> check_sides(const Plan& plan, const PlannedTake& planned, const PreparedTake& data) {
  std::vector<CheckRow> rows;
  if (!planned.level) return rows;  // they are not looked for
  for (std::size_t s = 0; s < plan.rig.size(); ++s) {
    double seen = 0.0, sides_swapped = 0.0;
    for (std::size_t i = 0; i < data.time.size(); ++i) {
      if (std::ranges::all_of(data.bodies.at(i, s).state,
                              [](TrackingState state) { return state == TrackingState::not_tracked; }))
        continue;
      seen += 1.0;
      sides_swapped += data.exchanges.at(i, s) ? 1.0 : 0.0;
    }
    if (seen > 0.0)
      rows.push_back({planned.take.id, plan.rig[s], "sides exchanged", "1", sides_swapped / seen});
  }
  return rows;
}

}  // namespace trilat
