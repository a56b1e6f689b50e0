// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "evaluators/alignment/interpolation.h"
#include "evaluators/bodies/exchange_repair.h"
#include "evaluators/bodies/observed_body.h"
#include "evaluators/fusion/joint_observation.h"
#include "evaluators/fusion/range_bearing.h"
#include "evaluators/fusion/self_calibration.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/sensor_track.h"
#include "pipeline/accuracy/tracking_summary.h"

namespace trilat {

// How often each sensor's view of each joint is occluded: by instant, sensor and joint. Empty when no method
// asks.
class OcclusionCounts {
 public:
  OcclusionCounts() = default;
  OcclusionCounts(std::size_t instants, std::size_t sensors)
      : sensors_(sensors), counts_(instants * sensors * kJointCount, 0) {}
  bool empty() const { return counts_.empty(); }
  std::uint8_t& at(std::size_t instant, std::size_t sensor, std::size_t joint) {
    return counts_[(instant * sensors_ + sensor) * kJointCount + joint];
  }
  std::uint8_t at(std::size_t instant, std::size_t sensor, std::size_t joint) const {
    return counts_[(instant * sensors_ + sensor) * kJointCount + joint];
  }

 private:
  std::size_t sensors_ = 0;
  std::vector<std::uint8_t> counts_;
};

// One person's bodies at the instants to evaluate, as the sensors give them, and the truth.
struct PersonTake {
  std::vector<HostTime> time;
  BodyTracks bodies{0, 0};
  std::vector<Eigen::Vector3d> truth_m;  // by instant and joint of the plan, NaN where there is none
  std::vector<CheckRow> checks;          // what the take was checked by
  std::vector<TakeNote> notes;
  bool rig_changed = false;  // check_sensors() found a fault of all sensors, which the truth shows, too
  std::vector<std::size_t> odd_sensors;  // that check_sensors() named: the truth is not judged by them
  bool joints_misread = false;  // in another unit or order, so that they tell nothing of poses and truth
  bool explained_by_sensor_check = false;  // a sensor check has reported a cause; later checks add no note

  const Eigen::Vector3d& truth(std::size_t instant, std::size_t joint, std::size_t joints) const {
    return truth_m[instant * joints + joint];
  }
};

// The take as methods see it, repaired as the study asks.
struct PreparedTake : PersonTake {
  SideSwapRepair exchanges = {};        // what was found, whether undone or not
  std::vector<float> heading_rad = {};  // by instant, NaN when not known
  std::array<OcclusionCounts, kOcclusionRules> occlusions =
      {};                                          // corrected always, the others when asked for
  ClockOffsetRow clock = {};                       // by motion, when the study asks
  SelfCalibration shown = {};                      // corrections of the calibration, estimated from the take
  std::vector<RigidTransform> corrected_rig = {};  // world_from_sensor by it, by rig sensor
  // Sigmas of methods whose sigma is estimated, with the stated and the corrected rig: by joint of the plan,
  // for the take's first and second half.
  std::array<std::vector<RaySigma>, 2> sigma = {};
};

// The truth of a take that mocap judges.
struct SampledTruth {
  std::vector<Eigen::Vector3d> at_instants_m;  // by instant and joint of the plan, NaN where there is none
  std::vector<PointPath> dense;  // by joint, in seconds since the first instant; none with a stated clock
  std::vector<std::string> oddities;
};

// A take as it was recorded, read whole.
struct RecordedTake {
  std::vector<SensorBodies> bodies;  // by rig sensor
  std::optional<SampledTruth> truth;
  bool is_closed = true;  // by its recorder
};
RecordedTake read_take(const Plan& plan, const PlannedTake& planned,
                       const std::function<bool()>& stop_requested);

// One person's bodies at the instants, as the sensors give them, and the truth of the mocap at its stated
// start; notes say what is odd about the streams, the sensors and the mocap. Takes the bodies out of
// `recorded`. InputError when the take cannot be evaluated at all: no ground truth for its time, no sensor
// that ever sees a joint that is asked for. This and what follows throw Interrupted when asked to stop.
PersonTake select_person(const Plan& plan, const PlannedTake& planned, RecordedTake& recorded);

// The take as methods see it: exchanges of left and right undone, the mocap's clock checked, occlusions
// counted, and what methods ask for estimated. A sensor that is left out is seen by no method: its tracked
// joints are the truth, which has none where it does not track (inferred ones are the tracker's guess); it
// and its predictors are put right each without the other.
PreparedTake view_take(const Plan& plan, const PlannedTake& planned, PersonTake followed,
                       const std::optional<SampledTruth>& truth, std::optional<std::size_t> left_out,
                       const std::function<bool()>& stop_requested);

// Reads a take, chooses its person and views it, with all sensors.
PreparedTake load_take(const Plan& plan, const PlannedTake& planned,
                       const std::function<bool()>& stop_requested);

// One joint at one instant as every sensor sees it.
void observe_joint(const PreparedTake& data, std::size_t instant, Joint joint,
                   const std::vector<RigidTransform>& world_from_sensor,
                   std::span<JointObservation> observations);

// The poses of the sensors as stated, or as the take corrects them, and a joint as they then see it.
const std::vector<RigidTransform>& rig_of(const PlannedTake& planned, const PreparedTake& data,
                                          bool is_corrected);
void observe_joint(const PreparedTake& data, const PlannedTake& planned, bool is_corrected,
                   std::size_t instant, Joint joint, std::span<JointObservation> observations);

// The sigmas that are estimated for a joint of the plan at an instant; NaN without.
RaySigma sigma_at(const PreparedTake& data, bool is_corrected, std::size_t instant, std::size_t joint);

// How often each sensor's view of the joint is occluded, by each rule; 0 for rules that no method asks for.
JointOcclusions occlusions_of(const PreparedTake& data, std::size_t instant, Joint joint);

// Whether the take is simulated with all true joints beside its session (truth.csv).
bool knows_hidden_views(const Take& take);

// 1 for every view from which a joint is truly hidden: less than the share of it that the simulated tracker
// needs is visible past the generated person's own body, sensors standing as the take's calibration says.
// InputError where the take's true joints are not known; Interrupted when asked to stop.
OcclusionCounts hidden_views(const PlannedTake& planned, const PreparedTake& data,
                             const std::function<bool()>& stop_requested);

// Counts of the views that each rule marks and that are truly hidden, by joint group; empty where the truly
// hidden views are not known.
std::vector<RuleRow> judge_rules(const Plan& plan, const PlannedTake& planned, const PreparedTake& data);

// The Cramer-Rao bound of the position error, by joint group: a mean over the instants with a truth and three
// ranges that span space. Range errors are taken as independent, and as large as their average.
std::vector<BoundRow> bounds_of(const Plan& plan, const PlannedTake& planned, const PreparedTake& data);

}  // namespace trilat
