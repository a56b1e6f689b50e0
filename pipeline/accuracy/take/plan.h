// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "datasets/base/time.h"
#include "datasets/results/summary.h"
#include "datasets/rig/calibration.h"
#include "datasets/rig/campaign.h"
#include "datasets/rig/rigid_transform.h"
#include "datasets/session/clock/session_clock.h"
#include "pipeline/accuracy/methods/method.h"
#include "pipeline/accuracy/methods/study_spec.h"
#include "pipeline/study/run_control.h"

namespace trilat {

// The truth of one take: its mocap; what each sensor sees, left out in turn; or nothing.
enum class TakeTruth : std::uint8_t { mocap, left_out_sensor, nothing };

// One take, looked into: which sensor of its session is which of the rig, where they stand, how their clocks
// run, and the instants to evaluate: start + i / rate_hz for i < instants, from the first to the last body
// frame of any sensor of the rig. A take that cannot be evaluated says why.
struct PlannedTake {
  Take take;
  Stage stage;
  TakeTruth truth = TakeTruth::mocap;
  bool ok = false;
  std::string place, problem;
  bool simulated = false;
  bool level = true;  // the calibration's world has y up, by its label
  bool in_mocap_world = false;
  bool truth_has_z_up = false;
  JointMapping mapping;
  std::vector<std::size_t> session_sensor;        // by rig sensor
  std::vector<SensorPose> poses;                  // by rig sensor, as calibrated
  std::vector<RigidTransform> world_from_sensor;  // by rig sensor
  std::vector<SensorClockMap> host_from_sensor;
  HostTime start;
  std::uint64_t instants = 0;
  std::string span_note;  // names sensors that recorded only a part of it
  NamedPoints points{};   // mocap's points by the plan's names, of a take without a session
};

// The work of a run, in an order that does not depend on threads. The id of a work item is the id of its
// take.
struct Plan {
  StudySpec study;
  Campaign campaign;
  std::vector<std::string> rig;  // names of the sensors
  std::vector<Method> methods;
  std::size_t reference = 0;       // the method that the others are compared with
  std::vector<Joint> joints;       // skeleton groups first, in the tables' order; none without sensors
  std::vector<std::string> names;  // of what is evaluated: the joints, or whatever points takes bring
  std::vector<PlannedTake> takes;
  bool simulated = false;

  Duration instant(std::uint64_t i) const { return duration_from_s(static_cast<double>(i) / study.rate_hz); }
};

// The number of the method that the study compares others with; InputError listing the methods when it is
// none.
std::size_t reference_of(const StudySpec& study, const std::vector<Method>& methods);

// Suffix of the condition of takes without motion capture in a campaign in which other takes have one. Such a
// take gives differences from a sensor, which are not errors.
inline constexpr const char* kPredicted = ", against a left-out sensor";

// Whether the truth of every take is what sensors see that are left out, and not mocap.
bool leaves_sensors_out(const Plan& plan);

// The takes of the conditions that the study asks for, once for each of its stages, the first stage first;
// InputError when it asks for a condition that no take is.
Campaign takes_of(const StudySpec& study, Campaign campaign);

// Opens every take once; Interrupted when asked to stop. Only what concerns all takes is an exception: a
// study that fits no rig, no joint mapped.
Plan make_plan(const StudySpec& study, const Campaign& campaign, const RunControl& control = {});

// The names of the plan's methods that takes bring begin here; all before are solved.
std::size_t first_external(const Plan& plan);

// Whether positions in the study's world are compared: true unless `rigid` is the only alignment.
bool compares_absolute_positions(const StudySpec& study);

// Each once, in the order of the takes.
std::vector<std::string> activities_of(const Plan& plan);

// The clock of a recorded sensor, by which its frames get their times. As fit_sensor_clock(); InputError for
// exact clocks of a session without the truth.json of a simulation beside it.
SensorClockMap clock_of(const SessionReader& session, std::size_t sensor, SensorClocks clocks);

// Opens the session, calibration, mapping and truth of a planned take, for the sensors of the rig, and plans
// its instants. InputError with the place where the take cannot be evaluated.
void open_take(PlannedTake& planned, const std::vector<std::string>& rig, const StudySpec& study);

}  // namespace trilat
