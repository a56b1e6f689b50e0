// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/session/session_types.h"

namespace trilat {

// How the position of a joint counts. A Kinect v2 measures depth from 0.5 m to 4.5 m and delivers some up to
// 8 m: a tracked or inferred joint nearer than 0.4 m or farther than 10 m of its sensor is no measurement.
// Drivers and converters write such positions, most often (0, 0, 0), for joints that were not seen.
enum class JointReading : std::uint8_t { not_tracked, seen, not_finite, out_of_reach };
inline constexpr double kMinJointDistance_m = 0.4, kMaxJointDistance_m = 10.0;
JointReading reading_of(const Body& body, std::size_t joint);

// Faults of where a sensor's joints lie: out of reach, in another unit, or in another order than the
// Kinect's, which shows in bones that no person has.
class JointFaults {
 public:
  void add(const Body& body);
  // Joints that count as not seen since they are out of reach.
  std::optional<std::string> out_of_reach_text() const;
  // Positions in another unit, or of other joints, which tell nothing of poses and truth.
  std::optional<std::string> misread_text() const;
  // Persons who hang upside down.
  std::optional<std::string> upside_down_text() const;
  // Share of feet that point backwards, against left x up of the body; nothing where few are seen.
  std::optional<double> backward_feet() const;

 private:
  static constexpr double kBin_m = 0.02;
  static constexpr std::size_t kBins = 100;  // the last one for all that are longer
  void add_stance(const Body& body, std::span<const bool> is_seen);
  double median_length_m(std::size_t bone) const;
  std::optional<double> odd_size() const;  // of the bones, in those of a person
  std::optional<std::string> too_long_text() const;
  std::optional<std::string> spine_text() const;
  std::optional<std::string> same_place_text() const;
  std::optional<std::string> unseen_text() const;

  std::array<std::uint64_t, kJointCount> out_of_reach_{};
  std::uint64_t bodies_ = 0;
  std::uint64_t joints_ = 0;                // tracked or inferred, and finite
  std::uint64_t behind_ = 0;                // of these, at negative z
  std::uint64_t at_sensor_ = 0;             // of those out of reach
  std::array<std::uint64_t, 2> in_unit_{};  // of those out of reach, within reach as millimetres, centimetres
  std::array<std::array<std::uint32_t, kBins>, kBoneCount> lengths_{};
  std::array<std::uint64_t, 3> spines_{}, exchanged_{};  // by kSpine
  std::uint64_t heads_ = 0, heads_below_ = 0;            // the feet
  std::uint64_t feet_ = 0, feet_backward_ = 0;
  std::array<std::uint64_t, 2 * kBoneCount> pairs_seen_{}, in_one_place_{};  // by apart()
};

// Exchanged sides or a mirrored axis: where the feet of all sensors of a session point backwards, of which
// `shares` holds the known ones. Those of a sensor behind the person do, too, since trackers take a back for
// a front. None of 200 sensors of real recordings has a share above 0.17.
std::optional<std::string> backward_feet_text(std::span<const double> shares);

// Finds what a sensor gives again: a driver that has nothing new repeats a body, to the last bit, under new
// time stamps. The third of equal bodies in a row, and those around it but the first, are no measurement;
// unless the body never changes.
class StaleBodies {
 public:
  // The next body of the sensor; `number` is its own.
  void add(const Body& body, std::size_t number);
  // The numbers of those that are stale, in no order.
  std::vector<std::size_t> finish();

 private:
  struct Run {
    std::array<std::array<float, 3>, kJointCount> position_m;
    std::vector<std::size_t> repeats;
    std::vector<std::size_t> stale;
    bool changes = false;
    void end();
  };
  std::map<std::uint64_t, Run> runs_;  // by tracking id
};

// Tells the bodies of one sensor apart. A body that moves more than 1 m from one frame to the next under one
// tracking id, in the median over its joints, is another body from there: trackers hand an id on to a second
// person. A person who runs may move farther between frames that lie far apart.
class BodyIdentities {
 public:
  // The identities of the bodies of the next frame, in their order: the tracking id, or a fresh number that
  // no tracker gives. A body that is again where an earlier one of its tracking id was is that one.
  std::vector<std::uint64_t> of(std::span<const Body> bodies, double time_s);
  // How often a tracking id went over from one body to another.
  std::uint64_t jumps() const { return jumps_; }

 private:
  struct Track {
    std::uint64_t identity;
    Body last;
    double time_s;
  };
  std::map<std::uint64_t, std::vector<Track>> tracks_;  // by tracking id
  std::map<std::uint64_t, std::uint64_t> latest_;       // identity by tracking id
  std::uint64_t fresh_ = std::uint64_t{1} << 63;
  std::uint64_t jumps_ = 0;
};

}  // namespace trilat
