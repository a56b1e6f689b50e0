// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "evaluators/solvers/point_estimate.h"
#include "pipeline/stream_fit/point_stream.h"
#include "pipeline/stream_fit/rig_change.h"
#include "pipeline/stream_fit/stream_fit.h"

namespace trilat {

// The change that turns one sensor's view into that of the others.
struct SensorChange {
  std::size_t sensor = 0;
  StreamFit fit;  // in the sensor's frame: the view of the others is the reference
  std::optional<double>
      pushed_s{};         // time from which the sensor stands elsewhere; then `fit` holds errors alone
  double pushed_m = 0.0;  // how far the view moved then
};

struct SensorsFit {
  // Sensors that agree, as they are stated or after `rig`; the largest group first. A sensor that sees
  // nothing is in none.
  std::vector<std::vector<std::size_t>> groups;
  std::optional<RigChange> rig;
  double before_m = 0.0, after_m = 0.0;  // mean distance between two sensors, without and with `rig`
  double height_m = 0.0;                 // of the high point above the low one, as it is stated
  std::vector<double> apart_m;        // of each sensor from the others of the first group; NaN when not known
  std::vector<SensorChange> changes;  // of sensors outside the first group, against it
};

// Fits all sensors to one body. Two sensors agree when they see the points within `kSensorsAgree_m` of each
// other in the mean, or differ by no change of that size. Where not all agree, poses that were exchanged or
// passed on in a circle, axes that all sensors have otherwise, and distances between the sensors of another
// scale are tried first: each explains all sensors at once. Else sensors outside the largest group are each
// compared with it: mirrored, late, of another pose, another scale, or pushed during the take.
// Nothing below these sizes is named: 20 cm of pose, 0.08 s, 8 % of one sensor's ranges, 4 % of distances.
// `upright`, in a world that is level: a person who is upside down for all sensors is a change of all, too.
SensorsFit fit_sensors(const std::vector<SensorStream>& sensors,
                       const std::optional<UprightPoints>& upright = {});

// Lag of a view behind others, and its standard deviation.
struct ViewLag {
  double lag_s = kNaN, sigma_s = kNaN;
};

// The lag, up to a second, at which the movements of both about each instant (0.1 s to both sides) agree
// best, with its standard deviation by a jackknife over blocks of time. What is constant or slow in two
// trackers is not in it. NaN for less than six seconds, and where a block decides or movements agree nearly
// as well without a lag. Both at the same instants.
ViewLag lag_of(const PointStream& view, const PointStream& others);

// A view of one pose until a time and another one from then on.
struct ViewPush {
  double at_s = 0.0, moved_m = 0.0;
  double judged_m = HUGE_VAL, plain_m = HUGE_VAL;  // what two poses leave, as ChangeErrors
};

// The time of all blocks' ends at which two poses leave least.
ViewPush best_push(const PointStream& view, const PointStream& others);

}  // namespace trilat
