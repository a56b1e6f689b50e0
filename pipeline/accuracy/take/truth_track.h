// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/time.h"
#include "pipeline/accuracy/take/marker_track.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

// Reads the mapped joints of a take's export from its start up to the last instant asked for. `joints` in the
// order wanted; those that the mapping does not map are never there. InputError for an asset that does not
// exist, has no position, or is a bone in local coordinates.
MarkerTrack truth_of(const PlannedTake& planned, const std::vector<Joint>& joints, Duration longest_gap,
                     MocapTime until = {std::numeric_limits<std::int64_t>::max()});

// Reads a take's truth and keeps it at the instants and, where `densely`, for the clock by motion; the
// markers themselves go, since those of an hour are as large as all that its sensors see. The mocap's time is
// the stated one + `offset`. InputError when it holds no truth for the session's time; Interrupted when asked
// to stop.
SampledTruth sample_truth(const Plan& plan, const PlannedTake& planned, Duration offset, bool densely,
                          const std::function<bool()>& stop_requested);

struct MotionClock {
  ClockOffsetRow row;
  std::string warning;  // what the trackers' lag does not explain, for the take's notes; empty when it does
};

// The likely cause why the motion does not say when the mocap starts, as a sentence; `status`: its name.
std::string cause_of(const std::string& status);

// By how much the mocap's stated start is off, as the motion shows: the mean of the sensors' positions
// against the dense truth. `data` has its times and bodies.
MotionClock clock_by_motion(const Plan& plan, const PlannedTake& planned, const PreparedTake& data,
                            const std::vector<PointPath>& truth);

}  // namespace trilat
