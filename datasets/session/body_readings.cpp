// SPDX-License-Identifier: MIT
#include "datasets/session/body_readings.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/units.h"

namespace trilat {
namespace {

constexpr double kJump_m = 1.0;
constexpr double kRunning_m_s = 5.0;
constexpr std::size_t kMinJoints = 3;    // that both frames see
constexpr std::size_t kMaxEarlier = 16;  // bodies of one tracking id that are remembered

double distance_m(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  const double x = double{a[0]} - double{b[0]}, y = double{a[1]} - double{b[1]},
               z = double{a[2]} - double{b[2]};
  return std::sqrt(x * x + y * y + z * z);
}

// Median distance of the joints that both bodies show; nothing for too few.
std::optional<double> moved_m(const Body& from, const Body& to) {
  std::vector<double> moved;
  for (std::size_t j = 0; j < kJointCount; ++j)
    if (reading_of(from, j) == JointReading::seen && reading_of(to, j) == JointReading::seen)
      moved.push_back(distance_m(from.position_m[j], to.position_m[j]));
  if (moved.size() < kMinJoints) return std::nullopt;
  const auto middle = moved.begin() + static_cast<std::ptrdiff_t>(moved.size() / 2);
  std::ranges::nth_element(moved, middle);
  return *middle;
}

// Longest distance from a joint to its parent in tall people, with a margin for a Kinect's errors; in the
// order of Joint.
constexpr std::array kMaxBone_m{HUGE_VAL, 0.42, 0.25, 0.35, 0.28, 0.50, 0.45, 0.25, 0.28,
                                0.50,     0.45, 0.25, 0.30, 0.65, 0.65, 0.35, 0.30, 0.65,
                                0.65,     0.35, 0.42, 0.25, 0.25, 0.25, 0.25};
// The same of a person of 1.7 m as a Kinect sees them.
constexpr std::array kUsualBone_m{HUGE_VAL, 0.31, 0.08, 0.15, 0.18, 0.27, 0.24, 0.08, 0.18,
                                  0.27,     0.24, 0.08, 0.08, 0.40, 0.38, 0.12, 0.08, 0.40,
                                  0.38,     0.12, 0.23, 0.08, 0.08, 0.08, 0.08};
static_assert(kMaxBone_m.size() == kJointCount && kUsualBone_m.size() == kJointCount);

constexpr std::uint64_t kMinBodies = 30;  // for what is usual
constexpr double kBackward = 0.7;         // share of feet from which all are taken to point backwards

// Units in which positions come from other drivers; millimetres first.
struct OtherUnit {
  const char* name;
  double per_metre;
};
constexpr std::array kOtherUnits{OtherUnit{"millimetres", 1000.0}, OtherUnit{"centimetres", 100.0}};

// Joints along the spine: the lower one is nearer to where it begins. A tracker's drift makes spine_shoulder
// and neck, 8 cm apart, change places by some centimetres.
constexpr double kClearly_m = 0.06;
struct SpineOrder {
  Joint from, lower, upper;
};
constexpr std::array kSpine{SpineOrder{Joint::spine_base, Joint::spine_mid, Joint::spine_shoulder},
                            SpineOrder{Joint::spine_mid, Joint::spine_shoulder, Joint::neck},
                            SpineOrder{Joint::spine_shoulder, Joint::neck, Joint::head}};

// Joints of the tables that are never in one place: with the joint before them, and left with right.
const std::vector<std::pair<Joint, Joint>>& apart() {
  static const std::vector<std::pair<Joint, Joint>> pairs = [] {
    std::vector<std::pair<Joint, Joint>> found;
    for (const Bone& bone : kBones) {
      if (!group_of(bone.child)) continue;
      found.emplace_back(bone.parent, bone.child);
      if (mirror_of(bone.child) > bone.child) found.emplace_back(bone.child, mirror_of(bone.child));
    }
    return found;
  }();
  return pairs;
}

bool is_in_reach(double range_m) { return range_m >= kMinJointDistance_m && range_m <= kMaxJointDistance_m; }

std::string size_text(double size) {
  constexpr double kFeetPerMetre = 3.28084, kNear = 0.35;
  return fmt::format("bones are some {:.1g} times as long as those of a person of 1.7 m; {}", size,
                     std::abs(size / kFeetPerMetre - 1.0) < kNear
                         ? "taken as feet positions are a person's: write them in metres"
                         : "are positions in metres?");
}

bool shows_enough(const Body& body) {
  std::size_t seen = 0;
  for (std::size_t j = 0; j < kJointCount; ++j) seen += reading_of(body, j) == JointReading::seen ? 1 : 0;
  return seen >= kMinJoints;
}

}  // namespace

JointReading reading_of(const Body& body, std::size_t joint) {
  const std::uint8_t state = body.tracking_state[joint];
  if (state != 1 && state != 2) return JointReading::not_tracked;
  const double range_m = distance_m(body.position_m[joint], {});
  if (!std::isfinite(range_m)) return JointReading::not_finite;
  return is_in_reach(range_m) ? JointReading::seen : JointReading::out_of_reach;
}

void JointFaults::add(const Body& body) {
  std::array<bool, kJointCount> is_seen{};
  ++bodies_;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const JointReading reading = reading_of(body, j);
    is_seen[j] = reading == JointReading::seen;
    joints_ += is_seen[j] || reading == JointReading::out_of_reach ? 1 : 0;
    behind_ += is_seen[j] && body.position_m[j][2] < 0.0F ? 1 : 0;
    if (reading != JointReading::out_of_reach) continue;
    ++out_of_reach_[j];
    const double range = distance_m(body.position_m[j], {});
    at_sensor_ += range == 0.0 ? 1 : 0;
    for (std::size_t u = 0; u < kOtherUnits.size(); ++u)
      in_unit_[u] += is_in_reach(range / kOtherUnits[u].per_metre) ? 1 : 0;
  }
  const auto between_m = [&](Joint one, Joint other) {
    const auto a = static_cast<std::size_t>(one), b = static_cast<std::size_t>(other);
    return is_seen[a] && is_seen[b] ? distance_m(body.position_m[a], body.position_m[b]) : kNaN;
  };
  for (std::size_t b = 0; b < kBones.size(); ++b)
    if (const double m = between_m(kBones[b].parent, kBones[b].child); std::isfinite(m))
      ++lengths_[b][static_cast<std::size_t>(std::min(m / kBin_m, static_cast<double>(kBins - 1)))];
  for (std::size_t k = 0; k < apart().size(); ++k) {
    const double m = between_m(apart()[k].first, apart()[k].second);
    pairs_seen_[k] += std::isfinite(m) ? 1 : 0;
    in_one_place_[k] += m == 0.0 ? 1 : 0;
  }
  for (std::size_t k = 0; k < kSpine.size(); ++k) {
    const double lower_m = between_m(kSpine[k].from, kSpine[k].lower),
                 upper_m = between_m(kSpine[k].from, kSpine[k].upper);
    spines_[k] += std::isfinite(lower_m + upper_m) ? 1 : 0;
    exchanged_[k] += lower_m > upper_m + kClearly_m ? 1 : 0;
  }
  add_stance(body, is_seen);
}

// A person faces along left x up, and a foot lies before its ankle.
void JointFaults::add_stance(const Body& body, std::span<const bool> is_seen) {
  using enum Joint;
  const auto seen = [&](auto... joints) { return (is_seen[static_cast<std::size_t>(joints)] && ...); };
  const auto at = [&](Joint j) {
    return Eigen::Map<const Eigen::Vector3f>(body.position_m[static_cast<std::size_t>(j)].data());
  };
  for (const auto& [ankle, foot] : {std::pair{ankle_left, foot_left}, std::pair{ankle_right, foot_right}}) {
    if (!seen(head, ankle)) continue;
    ++heads_;
    heads_below_ += at(head).y() < at(ankle).y() ? 1 : 0;
    if (!seen(foot, shoulder_left, shoulder_right, hip_left, hip_right, spine_shoulder, spine_base)) continue;
    const Eigen::Vector3f left = at(shoulder_left) - at(shoulder_right) + at(hip_left) - at(hip_right);
    ++feet_;
    feet_backward_ +=
        (at(foot) - at(ankle)).dot(left.cross(at(spine_shoulder) - at(spine_base))) < 0.0F ? 1 : 0;
  }
}

std::optional<std::string> JointFaults::misread_text() const {
  if (auto text = unseen_text()) return text;
  if (const auto size = odd_size()) return size_text(*size);
  if (auto text = same_place_text()) return text;
  if (auto text = too_long_text()) return text;
  return spine_text();
}

std::optional<double> JointFaults::backward_feet() const {
  if (feet_ < kMinBodies) return std::nullopt;
  return static_cast<double>(feet_backward_) / static_cast<double>(feet_);
}

std::optional<std::string> JointFaults::upside_down_text() const {
  if (heads_ < kMinBodies || 10 * heads_below_ < 9 * heads_) return std::nullopt;
  return fmt::format("heads lie below the feet: does y point down{}? A Kinect's points up",
                     backward_feet().value_or(1.0) >= kBackward ? "" : ", and x to the other side");
}

std::optional<std::string> backward_feet_text(std::span<const double> shares) {
  if (shares.empty() || std::ranges::min(shares) < kBackward) return std::nullopt;
  return fmt::format(
      "feet point backwards in {:.0f} % of the bodies: {}are left and right exchanged, or is an axis "
      "mirrored? A Kinect's x grows to its own left, its y upwards, its z away from it",
      100.0 * std::ranges::min(shares), shares.size() == 1 ? "is the sensor behind the person, " : "");
}

std::optional<std::string> JointFaults::out_of_reach_text() const {
  std::uint64_t all = 0;
  std::vector<std::string> joints;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    all += out_of_reach_[j];
    if (out_of_reach_[j] > 0)
      joints.push_back(fmt::format("{} {}", name_of(static_cast<Joint>(j)), out_of_reach_[j]));
  }
  if (all == 0 || odd_size() > 1.0) return std::nullopt;  // far away since all is too large
  const auto most_of = [](std::uint64_t count, std::uint64_t of) { return 10 * count >= 9 * of; };
  for (std::size_t u = 0; u < kOtherUnits.size(); ++u)
    if (most_of(all, joints_) && most_of(in_unit_[u], all))
      return fmt::format(
          "{} of {} joints lie farther than {:g} m of the sensor and count as not seen; taken as {} they are "
          "within its reach: write positions in metres",
          all, joints_, kMaxJointDistance_m, kOtherUnits[u].name);
  return fmt::format(
      "{} joints lie nearer than {:g} m or farther than {:g} m of the sensor ({}) and count as not seen{}",
      all, kMinJointDistance_m, kMaxJointDistance_m, fmt::join(joints, ", "),
      at_sensor_ == 0 ? ""
                      : fmt::format("; {} of them at (0, 0, 0), as is written for joints without a position",
                                    at_sensor_ == all ? "all" : std::to_string(at_sensor_)));
}

double JointFaults::median_length_m(std::size_t bone) const {
  const auto& counts = lengths_[bone];
  const std::uint64_t all = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  if (all < kMinBodies) return kNaN;
  std::size_t bin = 0;
  for (std::uint64_t below = counts[0]; 2 * below < all; below += counts[bin]) ++bin;
  return kBin_m * (static_cast<double>(bin) + 0.5);
}

// All bones too long or too short alike.
std::optional<double> JointFaults::odd_size() const {
  constexpr std::size_t kMinBones = 8;
  constexpr double kLong_m = 0.15;  // shorter ones are known to a third
  constexpr double kMaxSpread = 1.7, kMinSize = 0.5, kMaxSize = 1.6;
  std::vector<double> sizes;
  for (std::size_t b = 0; b < kBones.size(); ++b) {
    const double usual_m = kUsualBone_m[static_cast<std::size_t>(kBones[b].child)];
    if (const double m = median_length_m(b); usual_m >= kLong_m && m > 0.0) sizes.push_back(m / usual_m);
  }
  if (sizes.size() < kMinBones) return std::nullopt;
  std::ranges::sort(sizes);
  const double size = sizes[sizes.size() / 2];
  if (sizes[3 * sizes.size() / 4] > kMaxSpread * sizes[sizes.size() / 4]) return std::nullopt;
  return size >= kMinSize && size <= kMaxSize ? std::nullopt : std::optional(size);
}

std::optional<std::string> JointFaults::too_long_text() const {
  // A person whose limbs are hidden has up to 7 bones that are too long, three of them by half.
  constexpr std::size_t kMinBones = 6, kMinMuch = 4;
  constexpr double kMuch = 1.5;
  constexpr std::size_t kMaxNamed = 3;
  std::vector<std::string> bones;
  std::size_t much = 0;
  for (std::size_t b = 0; b < kBones.size(); ++b) {
    const double length_m = median_length_m(b);
    const double most_m = kMaxBone_m[static_cast<std::size_t>(kBones[b].child)];
    if (!(length_m > most_m)) continue;
    much += length_m > kMuch * most_m ? 1 : 0;
    bones.push_back(fmt::format("{} to {} {:.2f} m, at most {:.2f}", name_of(kBones[b].parent),
                                name_of(kBones[b].child), length_m, most_m));
  }
  if (bones.size() < kMinBones || much < kMinMuch) return std::nullopt;
  return fmt::format(
      "{} of {} bones are longer than those of a person ({}{}); are the joints in the order of a Kinect v2?",
      bones.size(), kBones.size(), fmt::join(std::span(bones).first(std::min(kMaxNamed, bones.size())), "; "),
      bones.size() > kMaxNamed ? "; ..." : "");
}

std::optional<std::string> JointFaults::spine_text() const {
  for (std::size_t k = 0; k < kSpine.size(); ++k)
    if (spines_[k] >= kMinBodies && 10 * exchanged_[k] >= 9 * spines_[k])
      return fmt::format("{} lies farther from {} than {} does: are the two exchanged?",
                         name_of(kSpine[k].lower), name_of(kSpine[k].from), name_of(kSpine[k].upper));
  return std::nullopt;
}

std::optional<std::string> JointFaults::unseen_text() const {
  if (bodies_ < kMinBodies) return std::nullopt;
  if (joints_ == 0)
    return fmt::format(
        "none of {} bodies has a joint that is tracked or inferred: write 2 for joints that are", bodies_);
  if (10 * behind_ >= 9 * joints_)
    return "joints lie behind the sensor, at negative z: has z another sign than the distance before a "
           "Kinect?";
  return std::nullopt;
}

std::optional<std::string> JointFaults::same_place_text() const {
  for (std::size_t k = 0; k < apart().size(); ++k)
    if (pairs_seen_[k] >= kMinBodies && 10 * in_one_place_[k] >= 9 * pairs_seen_[k])
      return fmt::format("{1} has the position of {0}, to the last bit: was one of them written twice?",
                         name_of(apart()[k].first), name_of(apart()[k].second));
  return std::nullopt;
}

void StaleBodies::Run::end() {
  constexpr std::size_t kMinRepeats = 2;
  if (repeats.size() >= kMinRepeats) stale.insert(stale.end(), repeats.begin(), repeats.end());
  repeats.clear();
}

void StaleBodies::add(const Body& body, std::size_t number) {
  const auto [entry, is_new] = runs_.try_emplace(body.tracking_id);
  Run& run = entry->second;
  if (!is_new && run.position_m == body.position_m) {
    run.repeats.push_back(number);
    return;
  }
  run.end();
  run.changes = !is_new;
  run.position_m = body.position_m;
}

std::vector<std::size_t> StaleBodies::finish() {
  std::vector<std::size_t> stale;
  for (auto& [id, run] : runs_) {
    run.end();
    if (run.changes) stale.insert(stale.end(), run.stale.begin(), run.stale.end());
  }
  return stale;
}

std::vector<std::uint64_t> BodyIdentities::of(std::span<const Body> bodies, double time_s) {
  std::vector<std::uint64_t> identities;
  std::set<std::uint64_t> taken;  // in this frame: two bodies may have one tracking id
  for (const Body& body : bodies) {
    std::vector<Track>& tracks = tracks_[body.tracking_id];
    Track* nearest = nullptr;
    double least_m = 0.0;
    for (Track& track : tracks) {
      if (taken.contains(track.identity)) continue;
      // Without joints in common nothing speaks against the same body, and less for it.
      const double m = moved_m(track.last, body).value_or(kJump_m);
      if (m > std::max(kJump_m, kRunning_m_s * (time_s - track.time_s))) continue;
      if (nearest && m >= least_m) continue;
      nearest = &track;
      least_m = m;
    }
    if (!nearest) {
      const bool is_first = tracks.empty();
      if (tracks.size() >= kMaxEarlier) tracks.erase(tracks.begin());
      nearest = &tracks.emplace_back(Track{is_first ? body.tracking_id : fresh_++, body, time_s});
    }
    const auto [latest, is_new] = latest_.emplace(body.tracking_id, nearest->identity);
    const bool is_alone = std::ranges::count(bodies, body.tracking_id, &Body::tracking_id) == 1;
    if (!is_new && latest->second != nearest->identity && is_alone) ++jumps_;
    latest->second = nearest->identity;
    if (shows_enough(body)) {  // to be compared with
      nearest->last = body;
      nearest->time_s = time_s;
    }
    taken.insert(nearest->identity);
    identities.push_back(nearest->identity);
  }
  return identities;
}

}  // namespace trilat
