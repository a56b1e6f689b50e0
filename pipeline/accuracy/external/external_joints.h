// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/mocap/read_mocap.h"
#include "evaluators/alignment/interpolation.h"
#include "pipeline/accuracy/methods/method.h"
#include "pipeline/accuracy/take/marker_track.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

// A file of markers of any format that is known: TRC, OptiTrack CSV, or a CSV of joints. InputError for
// others.
MocapHeader read_marker_header(const std::filesystem::path& file);
MocapTake read_markers(const std::filesystem::path& file);

// The points of a take's truth that it also brings: by its mapping; else by their names, or the joints that
// the names tell (propose_mapping()), whichever are more. InputError with the names of both where there is
// none.
NamedPoints correspondences(const Take& take);

// One note that names the mapped points that no file brings; empty when a file brings every point.
std::vector<std::string> unmatched_points(const Take& take, const std::vector<std::string>& names);

// A take without a session: its points, its instants on the mocap's clock, and which axis is up.
void open_external_take(PlannedTake& planned, const StudySpec& study);

// The points of a take without a session, as its mocap has them.
MarkerTrack truth_of_points(const Plan& plan, const PlannedTake& planned);

// The joints of one external file, in the order of the plan's names.
struct ExternalTrack {
  const ExternalJoints* joints = nullptr;
  std::size_t method = 0;  // of the plan
  MarkerTrack track;
  double first_s = 0.0;               // its first frame, in seconds since the take's first instant
  double offset_s = 0.0;              // by motion: what it shows at t was at t + offset_s
  std::vector<std::string> left_out;  // names of its that are none of the plan's
};
std::vector<ExternalTrack> read_external(const Plan& plan, const PlannedTake& planned);

// The plan's points at a time since the take's first instant; NaN where it has none.
void points_at(const ExternalTrack& external, double since_s, std::span<Eigen::Vector3d> points);

// Holds it against the truth, by name (fit_streams()), and looks for holes; each note has its size and the
// remedy. Puts it at the start that the motion shows where that is asked for.
std::vector<TakeNote> check_external(const Plan& plan, const PlannedTake& planned, const PointPath* truth,
                                     ExternalTrack& external);

// The external positions as paths of their method, at times in seconds since the first instant.
MethodTrajectories paths_of(const Plan& plan, const ExternalTrack& external,
                            const std::vector<double>& since_s);

}  // namespace trilat
