// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "datasets/rig/campaign.h"
#include "pipeline/accuracy/take/take_checks.h"
#include "pipeline/stream_fit/sensor_fit.h"
#include "pipeline/stream_fit/stream_words.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxSensorInstants = 20'000;
constexpr std::size_t kMaxSameLooks = 400;  // instants at which two streams are compared
constexpr std::size_t kMinSameRows = 100;   // joints at instants
constexpr double kSameStream_m = 0.0003;    // a tracker's noise alone is 1 mm

// Joints of the middle, and one of each pair.
std::vector<Joint> joints_once(const std::vector<Joint>& joints) {
  std::vector<Joint> once;
  for (const Joint joint : joints)
    if (joint <= mirror_of(joint) || std::ranges::find(joints, mirror_of(joint)) == joints.end())
      once.push_back(joint);
  return once;
}

// The middle of a joint and that of the other side, in the sensor's frame: trackers take a person who turns
// their back for one who faces them, which exchanges both. NaN where one of them is not tracked.
Eigen::Vector3d middle_of(const ObservedBody& body, Joint joint) {
  for (const Joint side : {joint, mirror_of(joint)})
    if (body.state[static_cast<std::size_t>(side)] != TrackingState::tracked)
      return Eigen::Vector3d::Constant(kNaN);
  return 0.5 * (body.at(joint) + body.at(mirror_of(joint)));
}

class SensorChecker {
 public:
  SensorChecker(const Plan& plan, const PlannedTake& planned, const BodyTracks& bodies)
      : plan_(plan), planned_(planned), bodies_(bodies) {}

  SensorChecks run() {
    find_same_streams();
    if (sensors_.size() < 2) return std::move(checks_);
    joints_ = joints_once(plan_.joints);
    const SensorsFit fit = fit_sensors(streams(), planned_.level ? upright_points() : std::nullopt);
    for (std::size_t k = 0; k < sensors_.size(); ++k)
      checks_.rows.push_back(
          {.take = planned_.take.id,
           .subject = name(k),
           .what = "apart",
           .unit = "m",
           .value = fit.apart_m[k],
           .limit = kSensorsAgree_m,
           .beyond = !fit.groups.empty() && !std::ranges::binary_search(fit.groups[0], k)});
    for (std::size_t g = 1; g < fit.groups.size(); ++g)
      for (const std::size_t k : fit.groups[g]) checks_.odd_sensors.push_back(sensors_[k]);
    checks_.rig_changed = fit.rig.has_value();
    checks_.is_one_person =
        fit.rig || (!fit.changes.empty() && std::ranges::all_of(fit.changes, [](const SensorChange& change) {
          return change.fit.status == StreamFitStatus::found && change.fit.after_m < kSensorsAgree_m;
        }));
    if (fit.rig)
      note_rig(fit);
    else if (!fit.changes.empty())
      note_changes(fit);
    else if (fit.groups.size() > 1)
      note_no_two(fit);
    else if (planned_.level)
      check_up();
    return std::move(checks_);
  }

 private:
  const std::string& name(std::size_t k) const { return plan_.rig[sensors_[k]]; }
  std::string names(const std::vector<std::size_t>& list) const {
    std::vector<std::string> texts;
    for (const std::size_t k : list) texts.push_back(name(k));
    if (texts.size() == 1) return texts[0];
    return fmt::format("{} and {}", fmt::join(texts.begin(), texts.end() - 1, ", "), texts.back());
  }
  void note(const std::filesystem::path& place, std::string text) {
    checks_.notes.push_back({planned_.take.id, false, place.string(), std::move(text)});
  }

  // Median distance of the joints as two trackers deliver them, each in its own frame.
  double raw_distance_m(std::size_t a, std::size_t b) const {
    std::vector<double> distances_m;
    const std::size_t step = std::max<std::size_t>(1, bodies_.instants() / kMaxSameLooks);
    for (std::size_t i = 0; i < bodies_.instants(); i += step)
      for (const Joint joint : plan_.joints)
        if (bodies_.at(i, a).has(joint) && bodies_.at(i, b).has(joint))
          distances_m.push_back((bodies_.at(i, a).at(joint) - bodies_.at(i, b).at(joint)).norm());
    return distances_m.size() < kMinSameRows ? kNaN : median(std::move(distances_m));
  }

  // Leaves out every stream that is another one again.
  void find_same_streams() {
    for (std::size_t b = 0; b < bodies_.sensors(); ++b) {
      const auto same =
          std::ranges::find_if(sensors_, [&](std::size_t a) { return raw_distance_m(a, b) < kSameStream_m; });
      if (same == sensors_.end()) {
        sensors_.push_back(b);
        continue;
      }
      checks_.rows.push_back({.take = planned_.take.id,
                              .subject = plan_.rig[b],
                              .what = "same stream",
                              .unit = "m",
                              .value = raw_distance_m(*same, b),
                              .limit = kSameStream_m,
                              .beyond = true});
      note(planned_.take.session,
           fmt::format("{} and {} hold the same bodies: one stream was recorded twice; leave one out with "
                       "\"sensors\" in the study, and record again",
                       plan_.rig[*same], plan_.rig[b]));
    }
  }

  std::vector<SensorStream> streams() const {
    const std::size_t step = 1 + bodies_.instants() / kMaxSensorInstants;
    std::vector<SensorStream> streams;
    for (const std::size_t s : sensors_) {
      SensorStream stream{{0.0, plan_.study.rate_hz / static_cast<double>(step), joints_.size(), {}},
                          planned_.world_from_sensor[s]};
      for (std::size_t i = 0; i < bodies_.instants(); i += step)
        for (const Joint joint : joints_) stream.in_sensor.at_m.push_back(middle_of(bodies_.at(i, s), joint));
      streams.push_back(std::move(stream));
    }
    return streams;
  }

  // A joint of the head or shoulders, and one of the legs.
  std::optional<UprightPoints> upright_points() const {
    const auto first_of = [&](std::initializer_list<Joint> wanted) {
      for (const Joint joint : wanted)
        if (const auto found = std::ranges::find(joints_, joint); found != joints_.end())
          return found - joints_.begin();
      return std::ptrdiff_t{-1};
    };
    const auto high = first_of({Joint::head, Joint::neck, Joint::spine_shoulder, Joint::shoulder_left});
    const auto low = first_of({Joint::ankle_left, Joint::knee_left, Joint::hip_left, Joint::spine_base});
    if (high < 0 || low < 0) return std::nullopt;
    return UprightPoints{static_cast<std::size_t>(high), static_cast<std::size_t>(low)};
  }

  // The axis along which the person stands in the calibration's world.
  void check_up() {
    UpAxisEstimator standing;
    const std::size_t step = 1 + bodies_.instants() / kMaxSameLooks;
    for (std::size_t i = 0; i < bodies_.instants(); i += step)
      for (const std::size_t s : sensors_)
        for (int j = 0; j < kJointCount; ++j)
          if (const auto joint = static_cast<Joint>(j); bodies_.at(i, s).has(joint))
            standing.add(joint, planned_.world_from_sensor[s] * bodies_.at(i, s).at(joint));
    if (standing.axis() != UpAxis::z) return;
    checks_.misplaced = checks_.rig_changed = true;
    note(planned_.take.calibration,
         "has z up, it seems: the person stands along z in its world. Write its poses in a world with y up, "
         "whose x, y, z are x, z, -y");
  }

  static std::string falls_text(double before_m, double after_m) {
    return fmt::format("falls from {:.1f} to {:.1f} cm", kCentimetresPerMetre * before_m,
                       kCentimetresPerMetre * after_m);
  }

  // Whether persons stand along y and before their sensors: then it is the calibration that has other axes.
  bool bodies_have_a_kinects_axes() const {
    UpAxisEstimator standing;
    std::size_t points = 0, before_sensor = 0;
    const std::size_t step = 1 + bodies_.instants() / kMaxSameLooks;
    for (std::size_t i = 0; i < bodies_.instants(); i += step)
      for (const std::size_t s : sensors_)
        for (int j = 0; j < kJointCount; ++j) {
          const auto joint = static_cast<Joint>(j);
          if (!bodies_.at(i, s).has(joint)) continue;
          const Eigen::Vector3d at_m = bodies_.at(i, s).at(joint);
          standing.add(joint, at_m);
          ++points;
          before_sensor += at_m.z() > 0.0 ? 1 : 0;
        }
    return standing.axis() == UpAxis::y && 10 * before_sensor > 9 * points;
  }

  void note_rig(const SensorsFit& fit) {
    const RigChange& rig = *fit.rig;
    const bool is_upside_down = fit.height_m < 0.0 && rig.convention.is_ours() && !rig.axes.isIdentity();
    const std::string effect = is_upside_down ? "put right, the person stands upright"
                                              : "put right, the mean distance between two sensors " +
                                                    falls_text(fit.before_m, fit.after_m);
    if (std::abs(rig.distances - 1.0) > 1e-9) {
      checks_.misplaced = true;
      const double percent = 100.0 * std::abs(1.0 / rig.distances - 1.0);
      note(planned_.take.calibration,
           fmt::format("places the sensors too far {}: all measure {:.1f} % too {}, by where they see the "
                       "person; {}. Is its length right (the wand's, the unit)? Calibrate again",
                       rig.distances > 1.0 ? "apart" : "together", percent,
                       rig.distances > 1.0 ? "short" : "long", effect));
    } else if (rig.convention.bodies_in_world) {
      note(planned_.take.session,
           "has bodies that lie in the world already, it seems: without the sensors' poses the mean distance "
           "between two sensors " +
               falls_text(fit.before_m, fit.after_m) + ". Write each sensor's bodies in its own frame");
    } else if (!rig.convention.is_ours() ||
               (!rig.axes.isIdentity() && rig.axes.determinant() > 0.0 && bodies_have_a_kinects_axes())) {
      checks_.misplaced = true;
      note(planned_.take.calibration, convention_text(rig) + "; " + effect + ". Write it so");
    } else if (!rig.axes.isIdentity()) {
      const bool is_mirrored =
          rig.axes.isApprox(Eigen::Vector3d(-1.0, 1.0, 1.0).asDiagonal().toDenseMatrix());
      note(planned_.take.session,
           fmt::format("all sensors see the person {}: with x, y, z of all bodies read as {}, {}. {}",
                       is_upside_down ? "upside down"
                       : is_mirrored  ? "as in a mirror"
                                      : "in other axes than the calibration has",
                       axes_text(rig.axes), effect,
                       is_mirrored ? "Record without mirroring" : "Write the bodies so"));
    } else {
      checks_.misplaced = true;
      note(planned_.take.calibration, poses_text(rig) + "; " + effect + ". Mend it");
    }
  }

  static std::string convention_text(const RigChange& rig) {
    using Inverse = PoseConvention::Inverse;
    std::vector<std::string> found, wanted;
    if (rig.convention.w_first) {
      found.emplace_back("quaternions in the order w, x, y, z");
      wanted.emplace_back("x, y, z, w");
    }
    if (rig.convention.inverse == Inverse::pose) {
      found.emplace_back("poses from the world to the sensor, as OpenCV gives them");
      wanted.emplace_back("the inverse, from the sensor to the world");
    }
    if (rig.convention.inverse == Inverse::rotation) {
      found.emplace_back("rotations from the world to the sensor beside positions in the world");
      wanted.emplace_back("the inverse rotations, from the sensor to the world");
    }
    if (!rig.axes.isIdentity()) {
      found.emplace_back("a camera's axes");
      wanted.emplace_back("x to the sensor's left, y up, z out of the lens");
    }
    return fmt::format("has {}, it seems; wanted are {}", fmt::join(found, ", and "),
                       fmt::join(wanted, ", and "));
  }

  std::string poses_text(const RigChange& rig) const {
    std::vector<std::size_t> moved;
    std::vector<std::string> passed;
    for (std::size_t k = 0; k < rig.pose_of.size(); ++k)
      if (rig.pose_of[k] != k) {
        moved.push_back(k);
        passed.push_back(fmt::format("{} stands where it has {}", name(k), name(rig.pose_of[k])));
      }
    if (moved.size() == 2) return fmt::format("has the poses of {} exchanged, it seems", names(moved));
    return fmt::format("has the poses of {} passed on among them, it seems: {}", names(moved),
                       fmt::join(passed, ", "));
  }

  // Sensors outside the largest group, one note for each.
  void note_changes(const SensorsFit& fit) {
    const bool are_two = sensors_.size() == 2;
    if (fit.groups.size() > 1 && !are_two && fit.groups[0].size() == fit.groups[1].size()) {
      checks_.misplaced = true;
      note(planned_.take.calibration,
           fmt::format("{} see the person {:.2f} m from where {} do, and nothing says which of them are "
                       "right",
                       names(fit.groups[0]), fit.changes.front().fit.before_m, names(fit.groups[1])));
      return;
    }
    for (const SensorChange& change : fit.changes) note_change(change, are_two);
  }

  struct Cause {
    std::string what, remedy;
    bool is_pose;
  };

  // Words for a sensor beside the others, or beside the only other one.
  struct SensorWords {
    std::string who, others, both;  // `both` is empty where there are more than two
  };

  void note_change(const SensorChange& change, bool are_two) {
    const std::string& who = name(change.sensor);
    const SensorWords words{who, are_two ? name(1 - change.sensor) : "the others",
                            are_two ? name(1 - change.sensor) + " and " + who : ""};
    if (change.pushed_s) return note_push(change, words);
    if (change.fit.status == StreamFitStatus::found) return note_cause(change, words);
    checks_.misplaced = true;
    const std::string why = undecided_text(change, words), leave_out = leave_out_text(words, "Leave");
    note(planned_.take.session,
         fmt::format("{} {:.2f} m {}; {}{}",
                     are_two ? words.both + " see the person" : who + " sees the person", change.fit.before_m,
                     are_two ? "apart" : "from where the others do", why,
                     why.ends_with('?') && !leave_out.empty() ? leave_out.substr(1) : leave_out));
  }

  static std::string leave_out_text(const SensorWords& words, const char* verb) {
    return words.both.empty() ? fmt::format(". {} it out with \"sensors\" in the study", verb) : "";
  }

  static std::string effect_text(const SensorChange& change, const SensorWords& words) {
    return fmt::format("put right, its mean distance from {} {}", words.others,
                       falls_text(change.fit.before_m, change.fit.after_m));
  }

  void note_push(const SensorChange& change, const SensorWords& words) {
    const bool are_two = !words.both.empty();
    checks_.misplaced = true;
    note(planned_.take.session,
         fmt::format("{} moved during the take: at {:.1f} s its view shifts by {:.2f} m against {}; {}. "
                     "Was it pushed? Then record again{}",
                     are_two ? "one of " + words.both : words.who, *change.pushed_s, change.pushed_m,
                     are_two ? "the other's" : "the others'", effect_text(change, words),
                     leave_out_text(words, "Or leave")));
  }

  void note_cause(const SensorChange& change, const SensorWords& words) {
    std::vector<std::string> what, remedy;
    const std::vector<Cause> causes = causes_texts(change.fit.changes.front(), change.fit.before_m, words);
    for (const Cause& cause : causes) {
      what.push_back(cause.what);
      remedy.push_back(cause.remedy);
    }
    const bool is_pose = std::ranges::all_of(causes, &Cause::is_pose);
    checks_.misplaced |= is_pose;
    note(is_pose ? planned_.take.calibration : planned_.take.session,
         fmt::format("{}; {}. {}{}", fmt::join(what, ", and "), effect_text(change, words),
                     fmt::join(remedy, "; "), leave_out_text(words, "Or leave")));
  }

  static std::string undecided_text(const SensorChange& change, const SensorWords& words) {
    if (change.fit.status != StreamFitStatus::one_of)
      return "none of these explains it: another pose, a mirror, a clock that is off by up to 3 s, another "
             "scale, a push during the take; is it the same person?";
    std::vector<std::string> changes;
    for (const StreamChange& one : change.fit.changes) {
      std::vector<std::string> what;
      for (const Cause& cause : causes_texts(one, change.fit.before_m, words)) what.push_back(cause.what);
      changes.push_back(fmt::format("{}", fmt::join(what, ", and ")));
    }
    return fmt::format("one of these explains it, and the motion does not say which: {}",
                       fmt::join(changes, "; or "));
  }

  static std::vector<Cause> causes_texts(const StreamChange& change, double before_m,
                                         const SensorWords& words) {
    const auto& [who, others, both] = words;
    std::vector<Cause> causes;
    if (change.mirrored)
      causes.push_back(
          {fmt::format("{} sees the person as in a mirror", both.empty() ? who : "one of " + both),
           "Record without mirroring", false});
    if (change.has_start)
      causes.push_back({fmt::format("{} shows movements {:.2f} s {} than {}", who, std::abs(change.start_s),
                                    change.start_s < 0.0 ? "later" : "earlier", others),
                        "If its clock is not the recording host's, record again", false});
    for (const SizeChange& size : change.sizes)
      causes.push_back({fmt::format("{} measures {:.1f} % too {}", who, 100.0 * std::abs(size.factor - 1.0),
                                    size.factor > 1.0 ? "long" : "short"),
                        "Write its depths in metres, and its joints unscaled", false});
    if (change.frame != FrameChange::none && !change.mirrored)
      causes.push_back(
          {both.empty()
               ? fmt::format("{} sees the person {:.2f} m from where the others do, by the pose it has", who,
                             before_m)
               : fmt::format("{} see the person {:.2f} m apart, by the poses it has: one pose is wrong", both,
                             before_m),
           "Calibrate again", true});
    return causes;
  }

  void note_no_two(const SensorsFit& fit) {
    checks_.misplaced = true;
    std::vector<std::size_t> all;
    for (const auto& group : fit.groups) all.insert(all.end(), group.begin(), group.end());
    std::ranges::sort(all);
    note(
        planned_.take.calibration,
        fmt::format("no two of {} see the person in one place: {:.2f} m apart in the mean, and neither poses "
                    "that were exchanged or passed on, nor other axes, nor another scale explain it; is it "
                    "the calibration of this take?",
                    names(all), fit.before_m));
  }

  const Plan& plan_;
  const PlannedTake& planned_;
  const BodyTracks& bodies_;
  std::vector<Joint> joints_;         // of the middle, and one of each pair
  std::vector<std::size_t> sensors_;  // that are compared, as indices of the rig
  SensorChecks checks_;
};

}  // namespace

SensorChecks check_sensors(const Plan& plan, const PlannedTake& planned, const BodyTracks& bodies) {
  if (bodies.sensors() < 2 || bodies.instants() == 0) return {};
  return SensorChecker(plan, planned, bodies).run();
}

}  // namespace trilat
