// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/results/simulation_assumptions.h"
#include "datasets/rig/skeleton.h"

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
  // In a document one number for all groups, or an object of some groups' numbers.
  struct Groups : std::array<double, kTrackerGroups> {
    void read(const Json& json, const JsonPlace& place, const About& about);
    static Json schema(const About& about);
  };
  // Systematic errors, fixed in the body's own frame, in three parts: shared by all sensors; by the direction
  // from which a sensor sees the body, as sine and cosine of its azimuth; of each sensor by itself.
  Groups bias_sigma_m{}, view_bias_sigma_m{}, own_bias_sigma_m{};
  // Errors that change while the joint moves, in the same three parts: AR(1) along the joint's path.
  Groups drift_sigma_m{}, view_drift_sigma_m{}, own_drift_sigma_m{};
  Groups jitter_sigma_m{};        // white
  Groups jump_rate_per_minute{};  // of one joint
  // Additional error of hidden joints, which goes with the direction of view.
  Groups inferred_error_sigma_m{};
  double drift_path_m = 0.0;  // in which the drift's correlation falls by e
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
  std::filesystem::path file = {};       // that it was read from; empty: simulation.json itself

  // Every parameter with its key and its limits; groups first, in the order of body_tracker.json.
  static void fields(auto& self, auto&& f) {
    f("bias_sigma_m", self.bias_sigma_m, Range{0.0, 1.0});
    f("view_bias_sigma_m", self.view_bias_sigma_m, Range{0.0, 1.0});
    f("own_bias_sigma_m", self.own_bias_sigma_m, Range{0.0, 1.0});
    f("drift_sigma_m", self.drift_sigma_m, Range{0.0, 1.0});
    f("view_drift_sigma_m", self.view_drift_sigma_m, Range{0.0, 1.0});
    f("own_drift_sigma_m", self.own_drift_sigma_m, Range{0.0, 1.0});
    f("jitter_sigma_m", self.jitter_sigma_m, Range{0.0, 1.0});
    f("jump_rate_per_minute", self.jump_rate_per_minute, Range{0.0, 60.0});
    f("inferred_error_sigma_m", self.inferred_error_sigma_m, Range{0.0, 1.0});
    f("drift_path_m", self.drift_path_m, Range{0.0, 100.0});
    f("ray_ratio", self.ray_ratio, Range{0.01, 100.0});
    f("unit_depth_share", self.unit_depth_share, Range{0.0, 1.0});
    f("lag_s", self.lag_s, Range{0.0, 10.0});
    f("jump_size_m", self.jump_size_m, Range{0.0, 1.0});
    f("jump_duration_s", self.jump_duration_s, Range{0.0, 60.0});
    f("least_visible_share", self.least_visible_share, Range{0.0, 1.0});
    f("hidden_as_tracked_share", self.hidden_as_tracked_share, Range{0.0, 1.0});
    f("back_view_angle_rad", self.back_view_angle_rad, Range{0.0, std::numbers::pi});
    f("exchanged_share", self.exchanged_share, Range{0.0, 1.0});
  }
  // "body_tracker" of simulation.json: an object of some values, where what it does not name stays as
  // declared; a document like the one that declares them; or the name of a file that holds either.
  void read(const Json& json, const JsonPlace& place, const About& about);
  static Json schema(const About& about);
};

// All values at 0: the tracker is exact.
BodyTrackerSpec exact_body_tracker();
// The declared defaults.
const BodyTrackerSpec& default_body_tracker();
// The document that declares them, with units, sources and intervals.
Json declared_body_tracker();
// A declared value as text, with what it rests on; a value that is not the default says that it was set.
std::vector<SimulationAssumption> tracker_parameters(const BodyTrackerSpec& spec);

}  // namespace trilat
