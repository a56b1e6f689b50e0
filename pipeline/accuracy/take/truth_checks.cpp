// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "datasets/mocap/read_mocap.h"
#include "pipeline/accuracy/take/take_checks.h"
#include "pipeline/stream_fit/stream_words.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxTruthInstants = 3000;  // that are looked at, spread over the take
// One Kinect v2 beside Vicon: up to 1.11 in 14 of 89 sound takes (docs/explanation/real_recordings.md).
constexpr double kMinScale = 0.15;
// A joint is far from its truth beyond both: markers and trackers mean different points of a joint, which
// makes up to a decimetre.
constexpr double kFar_m = 0.25, kFarTimes = 3.0;
// Trackers and markers lie up to a decimetre apart, and exchanged sides of a few joints leave the median.
constexpr double kApart_m = 0.3;
constexpr double kMinCovered = 0.5;  // of the take by its truth; less is said
constexpr StreamFitOptions kLookedFor{.min_scale = kMinScale,
                                      .causes = kSizeCause | kPointSizeCause | kLaterSizeCause |
                                                kAxisSizeCause | kSidesCause | kMirrorCause | kRootCause,
                                      .any_frame = true};

class TruthChecker {
 public:
  TruthChecker(const Plan& plan, const PlannedTake& planned, const PreparedTake& data)
      : plan_(plan), planned_(planned), data_(data) {
    for (const Joint joint : plan.joints) names_.emplace_back(name_of(joint));
  }

  TakeChecks run() {
    const auto [seen, truth] = streams();
    StreamFit fit = fit_streams({seen, truth}, mirrored_points(names_), kLookedFor);
    if (is_doubtful(fit)) fit.status = StreamFitStatus::unexplained;
    add({.subject = "mocap", .what = "laid over", .unit = "m", .value = fit.before_m});
    checks_.rows.back().beyond = checks_.names_cause =
        fit.status == StreamFitStatus::found || fit.status == StreamFitStatus::one_of;
    if (fit.status == StreamFitStatus::found && !fit.changes.front().root)
      note_change(fit);
    else if (fit.status == StreamFitStatus::found)
      note(planned_.take.mocap, stream_note(without_frames(fit), {"what the sensors see", names_}));
    else if (fit.status == StreamFitStatus::one_of)
      note(planned_.take.mocap, stream_note(without_frames(fit), {"what the sensors see", names_}));
    else if (const std::string text = text_over_time({seen, truth}, fit); !text.empty())
      note(planned_.take.mocap, text);
    else
      check_place(seen, truth);
    check_coverage();
    find_far(fit);
    return std::move(checks_);
  }

  std::string frame_text() const {
    if (!planned_.in_mocap_world) return {};
    const auto [seen, truth] = streams();
    constexpr double kMinStart_s = 0.15;  // trackers lag by less
    const StreamFit fit = fit_streams(
        {seen, truth}, mirrored_points(names_),
        {.min_start_s = kMinStart_s, .causes = kStartCause | kRateCause | kShiftCause | kTurnCause});
    constexpr double kMaxLeft_m = 0.2;  // what leaves more is not all that is wrong
    if (fit.changes.empty() || (causes_of(fit.changes.front()) & (kStartCause | kRateCause)) != 0 ||
        fit.after_m > kMaxLeft_m)
      return {};
    const std::string text = stream_note(fit, {"what the sensors see", names_});
    return fit.status == StreamFitStatus::found ? text + ", or calibrate the sensors in its world" : text;
  }

  std::string clock_text() const {
    const auto [seen, truth] = streams();
    const StreamFit fit =
        fit_streams({seen, truth}, mirrored_points(names_),
                    {.causes = kStartCause | kRateCause, .any_frame = !planned_.in_mocap_world});
    if (fit.status != StreamFitStatus::found && fit.status != StreamFitStatus::one_of) return {};
    std::vector<std::string> what, remedies;
    for (const StreamChange& change : fit.changes) {
      auto [fault, remedy] = clock_fault(change);
      what.push_back(std::move(fault));
      remedies.push_back(std::move(remedy));
    }
    return fmt::format(
        "{}, by the motion{}: put right, its mean distance from what the sensors see falls from {:.1f} to "
        "{:.1f} cm; {}",
        fmt::join(what, ", or "), what.size() > 1 ? ", which does not say which" : "",
        kCentimetresPerMetre * fit.before_m, kCentimetresPerMetre * fit.after_m,
        fmt::join(remedies, ", or "));
  }

 private:
  // Words for a start or rate of the truth that differs from the stated one, and for what to write instead.
  std::pair<std::string, std::string> clock_fault(const StreamChange& change) const {
    const HostTime stated{planned_.take.mocap_start_host_ns};
    const HostTime start =
        planned_.start +
        duration_from_s(change.start_s - change.stretch * (planned_.start - stated).seconds());
    const std::string remedy = fmt::format("write \"mocap_start_host_ns\": {}", start.ns);
    if (!change.has_stretch)
      return {fmt::format("starts {:.2f} s {} than stated", std::abs((start - stated).seconds()),
                          start > stated ? "later" : "earlier"),
              remedy};
    const double rate_hz = read_mocap_header(planned_.take.mocap).export_rate_hz;
    return {fmt::format("runs {:.3f} times as fast as the sensors see the person move", change.stretch),
            remedy + (std::isfinite(rate_hz)
                          ? fmt::format(", and into its header a rate of {:.4g} Hz, where {:.4g} Hz stand",
                                        rate_hz / change.stretch, rate_hz)
                          : std::string(", and its true rate into its header"))};
  }

  struct Streams {
    PointStream seen, truth;
  };
  Streams streams() const {
    const std::size_t step = 1 + data_.time.size() / kMaxTruthInstants;
    const double rate_hz = plan_.study.rate_hz / static_cast<double>(step);
    const std::size_t joints = plan_.joints.size();
    Streams streams{{0.0, rate_hz, joints, {}}, {0.0, rate_hz, joints, {}}};
    for (std::size_t i = 0; i < data_.time.size(); i += step)
      for (std::size_t j = 0; j < joints; ++j) {
        streams.seen.at_m.push_back(mean_of_sensors(i, plan_.joints[j]));
        streams.truth.at_m.push_back(data_.truth(i, j, joints));
      }
    return streams;
  }

  // A mirror that leaves much: a motion run backwards looks mirrored.
  static bool is_doubtful(const StreamFit& fit) {
    constexpr double kMaxLeft_m = 0.12;
    return !fit.changes.empty() && fit.changes.front().mirrored && fit.after_m > kMaxLeft_m;
  }
  // The note on a constant of each joint, a part in another frame, or a frame that moves; empty without one.
  std::string text_over_time(const StreamPair& pair, const StreamFit& fit) const {
    const StreamWords words{"what the sensors see", names_};
    const double before_m =
        planned_.in_mocap_world
            ? mean_of_known(errors_of_change(pair, blocks_of(pair), StreamChange{}).plain_m)
            : fit.before_m;
    if (const auto after_m = find_own_places(pair, fit.before_m))
      return own_places_note(*after_m, before_m, words);
    const auto drift = find_frame_drift(pair);
    if (!drift || !is_named(*drift)) return {};
    constexpr double kAsWell = 1.4;  // a drift has a frame for each piece
    StreamFitOptions options;
    options.min_scale = kMinScale;
    const auto part = find_part_change(pair, mirrored_points(names_), options, kAsWell * drift->after_m);
    return part ? part_note(*part, before_m, words) : drift_note(*drift, before_m, words);
  }
  // Whether a frame moved by more than trackers do that see a person from other sides.
  static bool is_named(const FrameDrift& drift) {
    constexpr double kMinShift_m = 0.15, kMinTurn_rad = 0.15;
    return drift.shift_m > kMinShift_m || drift.turn_rad > kMinTurn_rad;
  }
  // The two worlds may lie anyhow, so a note does not name the frame that lays them over each other.
  static StreamFit without_frames(StreamFit fit) {
    for (StreamChange& change : fit.changes)
      if (!change.mirrored) change.frame = FrameChange::none;
    return fit;
  }
  Eigen::Vector3d mean_of_sensors(std::size_t instant, Joint joint) const {
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    double count = 0.0;
    for (std::size_t s = 0; s < data_.bodies.sensors(); ++s) {
      if (std::ranges::find(data_.odd_sensors, s) != data_.odd_sensors.end()) continue;
      const ObservedBody& body = data_.bodies.at(instant, s);
      if (body.state[static_cast<std::size_t>(joint)] != TrackingState::tracked) continue;
      sum_m += planned_.world_from_sensor[s] * body.at(joint);
      count += 1.0;
    }
    return sum_m / count;  // NaN without any
  }
  void add(CheckRow row) {
    row.take = planned_.take.id;
    checks_.rows.push_back(std::move(row));
  }
  void note(const std::filesystem::path& place, std::string text) {
    checks_.notes.push_back({planned_.take.id, false, place.string(), std::move(text)});
  }

  void note_change(const StreamFit& fit) {
    const StreamChange& change = fit.changes.front();
    const unsigned causes = named_causes(change, kLookedFor);
    const std::string effect =
        fmt::format("put right, its mean distance from what the sensors see falls from {:.1f} to {:.1f} cm",
                    kCentimetresPerMetre * fit.before_m, kCentimetresPerMetre * fit.after_m);
    std::vector<std::string> what, remedies;
    for (const SizeChange& size : change.sizes) {
      what.push_back(
          size.point ? fmt::format("moves {} {:.2f} times as far as the sensors see it move{}",
                                   names_[*size.point], size.factor, unit_text(size))
          : size.axis
              ? fmt::format("has {} {} times as large as the sensors see it{}", "xyz"[*size.axis],
                            factor_text(size), unit_text(size))
              : fmt::format(
                    "shows movements and a body {} times as large as the sensors do{}{}", factor_text(size),
                    size.at_s ? fmt::format(" {} {:.2f} s", size.until ? "until" : "from", *size.at_s) : "",
                    unit_text(size)));
      remedies.push_back(size.point ? "is the unit of its asset right?"
                         : size.axis
                             ? fmt::format("divide its {} by {}", "xyz"[*size.axis], factor_text(size))
                             : "is the export's unit right?");
    }
    if ((causes & kMirrorCause) != 0) {
      what.emplace_back("is mirrored, it seems");
      remedies.emplace_back("export it with right-handed axes");
    }
    if ((causes & kSidesCause) != 0) {
      what.push_back(order_text(change, names_) + ", it seems");
      remedies.emplace_back("mend the mapping");
    }
    note(causes == kSidesCause ? planned_.take.mapping : planned_.take.mocap,
         fmt::format("{}: {}; {}", fmt::join(what, ", and "), effect, fmt::join(remedies, "; ")));
  }

  // The truth beside what the sensors see, as the stated start and the poses have it. A clock by the motion
  // says more where it says anything.
  void check_place(const PointStream& seen, const PointStream& truth) {
    if (!planned_.in_mocap_world || !compares_absolute_positions(plan_.study)) return;
    std::vector<double> apart_m;
    for (std::size_t k = 0; k < seen.at_m.size(); ++k)
      if (const double m = (seen.at_m[k] - truth.at_m[k]).norm(); std::isfinite(m)) apart_m.push_back(m);
    if (apart_m.empty()) return;
    const double median_m = median(std::move(apart_m));
    add({.subject = "mocap",
         .what = "apart",
         .unit = "m",
         .value = median_m,
         .limit = kApart_m,
         .beyond = median_m > kApart_m});
    const bool is_explained =
        data_.explained_by_sensor_check ||
        std::ranges::find(data_.notes, planned_.take.mocap.string(), &TakeNote::place) != data_.notes.end();
    if (!(median_m > kApart_m) || is_explained) return;
    const std::string frame = frame_text();
    note(planned_.take.mocap,
         !frame.empty()
             ? frame
             : fmt::format(
                   "lies {:.2f} m from where the sensors see the joints{}; is mocap_start_host_ns right, "
                   "and the calibration in its world?",
                   median_m,
                   plan_.study.clock == ClockSource::stated ? "" : ", and the motion does not say why"));
  }

  void check_coverage() {
    const std::size_t joints = plan_.joints.size();
    std::size_t covered = 0;
    for (std::size_t i = 0; i < data_.time.size(); ++i) {
      bool any = false;
      for (std::size_t j = 0; j < joints; ++j) any |= data_.truth(i, j, joints).allFinite();
      covered += any ? 1 : 0;
    }
    if (static_cast<double>(covered) >= kMinCovered * static_cast<double>(data_.time.size())) return;
    note(planned_.take.mocap, fmt::format("has truth for {:.1f} s of the {:.1f} s that the sensors recorded; "
                                          "the rest is not evaluated",
                                          static_cast<double>(covered) / plan_.study.rate_hz,
                                          static_cast<double>(data_.time.size()) / plan_.study.rate_hz));
  }

  // Joints that lie far from where the sensors see them when all are laid over each other.
  void find_far(const StreamFit& fit) {
    std::vector<double> known_m;
    for (const double m : fit.of_point_m)
      if (std::isfinite(m)) known_m.push_back(m);
    if (known_m.size() < 3) return;
    const double usual_m = median(std::move(known_m)), limit_m = std::max(kFar_m, kFarTimes * usual_m);
    for (std::size_t j = 0; j < names_.size(); ++j) {
      if (!std::isfinite(fit.of_point_m[j])) continue;
      const bool is_far = fit.of_point_m[j] > limit_m;
      add({.subject = names_[j],
           .what = "place",
           .unit = "m",
           .value = fit.of_point_m[j],
           .limit = limit_m,
           .beyond = is_far});
      if (is_far)
        note(planned_.take.mapping,
             fmt::format("maps {} to what lies {:.2f} m from where the sensors see it, other joints {:.2f} m "
                         "in the median; is it the right asset?",
                         names_[j], fit.of_point_m[j], usual_m));
    }
  }

  const Plan& plan_;
  const PlannedTake& planned_;
  const PreparedTake& data_;
  std::vector<std::string> names_;  // of the plan's joints
  TakeChecks checks_;
};

}  // namespace

std::string clock_fault_text(const Plan& plan, const PlannedTake& planned, const PreparedTake& data) {
  return TruthChecker(plan, planned, data).clock_text();
}

std::string frame_fault_text(const Plan& plan, const PlannedTake& planned, const PreparedTake& data) {
  return TruthChecker(plan, planned, data).frame_text();
}

TakeChecks check_truth(const Plan& plan, const PlannedTake& planned, const PreparedTake& data) {
  return TruthChecker(plan, planned, data).run();
}

}  // namespace trilat
