// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/results/declared_parameters.h"
#include "datasets/skeleton/skeleton.h"

namespace trilat {

// Joints for which the body tracker's errors are of one size; left and right pooled. The spine's joints and
// the neck are the trunk; thumbs go with the hand tips.
enum class TrackerGroup { trunk, head, shoulder, elbow, wrist, hand, hand_tip, hip, knee, ankle, foot };
inline constexpr std::size_t kTrackerGroups = 11;
TrackerGroup tracker_group_of(Joint joint);
std::string_view name_of(TrackerGroup group);

// How a Kinect's body tracker differs from the truth; 0 switches any of it off. Sigmas are per axis. Defaults
// and their sources are in body_tracker.json.
struct BodyTrackerSpec {
  using Groups = std::array<double, kTrackerGroups>;
  // What is systematic, fixed in the body's own frame: the same for all sensors; what goes with the direction
  // from which a sensor sees the body, as sine and cosine of its azimuth; of each sensor by itself.
  Groups bias_sigma_m{}, view_bias_sigma_m{}, own_bias_sigma_m{};
  // What changes while the joint moves, in the same three parts: AR(1) along the joint's path.
  Groups wander_sigma_m{}, view_wander_sigma_m{}, own_wander_sigma_m{};
  Groups jitter_sigma_m{};        // white
  Groups jump_rate_per_minute{};  // of one joint
  // What hidden joints are off by more, which goes with the direction of view.
  Groups inferred_error_sigma_m{};
  double wander_path_m = 0.0;  // in which the drift's correlation falls by e
  // How the sum of bias, drift and jitter splits: sigma along the ray over sigma across it, the total kept.
  double ray_ratio = 1.0;
  double unit_depth_share = 0.0;  // of the depth error of the sensor's unit (offset and wiggling)
  double lag_s = 0.0;             // time constant of a first-order filter
  double jump_size_m = 0.0;
  double jump_duration_s = 0.0;
  double least_visible_share = 0.0;      // a joint of which less is visible is hidden
  double hidden_as_tracked_share = 0.0;  // share of hidden stretches that are reported as tracked
  double back_view_angle_rad = 0.0;      // body's forward to the sensor; beyond, the back is seen
  double exchanged_share = 0.0;          // share of stretches seen from behind that are taken for the front
};

// All values at 0: the tracker is exact.
BodyTrackerSpec exact_body_tracker();
// The declared defaults.
const BodyTrackerSpec& default_body_tracker();
// The document that declares them, with units, sources and intervals.
Json declared_body_tracker();
// "body_tracker" of simulation.json: such a document, or an object of some values; what it does not name
// stays as declared. A value of groups is one number for all or an object of some groups' numbers.
BodyTrackerSpec read_body_tracker(JsonObject& parent);

// A declared value as text, with what it rests on; a value that is not the default says that it was set.
std::vector<DeclaredParameter> tracker_parameters(const BodyTrackerSpec& spec);

}  // namespace trilat
