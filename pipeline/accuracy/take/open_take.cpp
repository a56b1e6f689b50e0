// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/rig/calibration.h"
#include "datasets/session/clock/agent_clock.h"
#include "datasets/session/clock/true_clocks.h"
#include "datasets/session/session_reader.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/truth_track.h"

namespace trilat {
namespace {

// Instants of the truth that show which axis points up: so many with a joint, or more until one does, of at
// most so many.
constexpr double kProbe_s = 0.1, kFirst_s = 1.5;
constexpr double kShortSpan_s = 1.0;  // a sensor that misses more of a take is named

struct HostSpan {
  HostTime first, last;
};

HostSpan span_of(const SessionReader& session, std::size_t sensor, const SensorClockMap& map) {
  const SensorDescription& description = session.header().sensors[sensor];
  const std::uint64_t frames = session.counts(sensor).body_frames;
  const std::string place = session.path().string() + ":/sensors/" + description.name + "/body_frames";
  if (frames == 0) throw InputError(place, "holds no body frames, so there is nothing to trilaterate");
  const auto first = session.stamps(sensor, FrameStream::bodies, 0, 1);
  const auto last = session.stamps(sensor, FrameStream::bodies, frames - 1, 1);
  return {map(first[0]), map(last[0])};
}

// The instants at which any sensor of the rig was recording.
void plan_instants(PlannedTake& planned, const std::vector<std::string>& rig,
                   const std::vector<HostSpan>& spans, double rate_hz) {
  HostTime first = spans[0].first, last = spans[0].last;
  for (const HostSpan& span : spans) {
    first = std::min(first, span.first);
    last = std::max(last, span.last);
  }
  for (std::size_t s = 0; s < rig.size(); ++s) {
    const double recorded_s = (spans[s].last - spans[s].first).seconds();
    if ((last - first).seconds() > recorded_s + kShortSpan_s)
      planned.span_note +=
          fmt::format("{}{} recorded only {:.1f} s of {:.1f} s", planned.span_note.empty() ? "" : ", ",
                      rig[s], recorded_s, (last - first).seconds());
  }
  const auto latest = std::ranges::max_element(spans, {}, [](const HostSpan& span) { return span.first.ns; });
  const auto earliest =
      std::ranges::min_element(spans, {}, [](const HostSpan& span) { return span.last.ns; });
  if (latest->first > earliest->last)
    planned.span_note += fmt::format(
        "{}{} begins {:.1f} s after {} ends (are their times of clocks that have nothing in common?)",
        planned.span_note.empty() ? "" : "; ", rig[static_cast<std::size_t>(latest - spans.begin())],
        (latest->first - earliest->last).seconds(), rig[static_cast<std::size_t>(earliest - spans.begin())]);
  if (!planned.span_note.empty())
    planned.span_note += "; what cannot be answered without it counts against a method's coverage";
  planned.start = first;
  planned.instants = static_cast<std::uint64_t>(std::floor((last - first).seconds() * rate_hz)) + 1;
  constexpr std::uint64_t kMaxCount = 2'000'000;  // a take is held in memory: 18 hours at 30 Hz
  if (planned.instants > kMaxCount)
    throw InputError(planned.take.session.string(),
                     fmt::format("covers {:.0f} s, more than can be evaluated at {} Hz",
                                 (last - first).seconds(), rate_hz));
}

// The ground truth is in OptiTrack's world; only a rigid alignment forgives poses in another.
void check_world(const Calibration& calibration, const StudySpec& study, const std::string& place) {
  for (AlignmentKind kind : study.alignments)
    if (calibration.world != "optitrack" && kind != AlignmentKind::rigid)
      throw InputError(place + " /world",
                       "is \"" + calibration.world +
                           "\", but the ground truth is in OptiTrack's world; calibrate with --mocap, or "
                           "evaluate with \"alignments\": [\"rigid\"] alone");
}

// The mapping of a take without truth: nothing limits the joints.
JointMapping every_joint() {
  JointMapping mapping;
  for (int j = 0; j < kJointCount; ++j) mapping.joints.push_back({static_cast<Joint>(j), {}});
  return mapping;
}

// Reads the truth's first seconds, in which its assets must exist. InputError where no axis is stated and the
// person stands along z in them; a take that shows nothing is taken as y.
void check_up_axis(const PlannedTake& planned, const std::vector<Joint>& joints) {
  const MarkerTrack truth =
      truth_of(planned, joints, duration_from_s(kProbe_s), MocapTime{} + duration_from_s(kFirst_s));
  if (planned.take.up_axis || !planned.level) return;
  UpAxisEstimator standing;
  std::vector<Eigen::Vector3d> points(joints.size());
  for (double t_s = 0.0; t_s <= kFirst_s; t_s += kProbe_s) {
    truth.at(MocapTime{} + duration_from_s(t_s), points);
    for (std::size_t j = 0; j < joints.size(); ++j) standing.add(joints[j], points[j]);
  }
  if (standing.axis() == UpAxis::z) throw InputError(planned.take.mocap.string(), kStandsAlongZ);
}

// By name; InputError with what to do where the session lacks it.
std::size_t sensor_of(const SessionReader& session, const std::string& name) {
  try {
    return session.sensor_index(name);
  } catch (const InputError& error) {
    throw InputError(error.place(), error.problem() + "; name those to use under \"sensors\" in the study");
  }
}

}  // namespace

SensorClockMap clock_of(const SessionReader& session, std::size_t sensor, SensorClocks clocks) {
  SensorClockMap map = fit_sensor_clock(session, sensor);
  if (clocks == SensorClocks::exact) {
    const std::optional<TrueClocks> truth = true_clocks(session, session.header().sensors[sensor].name);
    if (!truth)
      throw InputError(session.path().string(),
                       "has no truth.json beside it, so its exact clocks are not known: \"sensor_clocks\": "
                       "\"exact\" is for simulations");
    map.epochs.resize(1);
    map.epochs[0].line = truth->host_from_sensor;
    map.epochs[0].line.origin_to = map.epochs[0].line.origin_to + map.latency;
  }
  if (clocks == SensorClocks::causal) map.live = LiveClock(session.clock_exchanges(sensor));
  if (clocks == SensorClocks::printed) map.live = [](AgentTime arrival) { return HostTime{arrival.ns}; };
  return map;
}

void open_take(PlannedTake& planned, const std::vector<std::string>& rig, const StudySpec& study) {
  if (planned.take.mocap.empty() && planned.truth == TakeTruth::mocap)
    throw InputError("take \"" + planned.take.id + '"',
                     "has no \"mocap\" to be judged by; with \"truth\": \"auto\" the study judges such a "
                     "take by its own sensors, with \"left_out_sensor\" every take");
  const SessionReader session(planned.take.session);
  planned.simulated = session.header().simulated;
  const bool has_truth = planned.truth == TakeTruth::mocap;
  planned.mapping = planned.take.mapping.empty() ? every_joint() : read_mapping(planned.take.mapping);
  const Calibration calibration = read_calibration(planned.take.calibration);
  if (has_truth) check_world(calibration, study, planned.take.calibration.string());
  planned.in_mocap_world = calibration.world == "optitrack";
  planned.level =
      !calibration.world.starts_with("sensor ") || calibration.world.find("floor") != std::string::npos;
  std::vector<HostSpan> spans;
  for (const std::string& name : rig) {
    const std::size_t sensor = sensor_of(session, name);
    planned.session_sensor.push_back(sensor);
    planned.poses.push_back(pose_of(calibration, name, planned.take.calibration.string()));
    planned.world_from_sensor.push_back(planned.poses.back().world_from_sensor);
    planned.host_from_sensor.push_back(clock_of(session, sensor, planned.stage.sensor_clocks));
    spans.push_back(span_of(session, sensor, planned.host_from_sensor.back()));
  }
  plan_instants(planned, rig, spans, study.rate_hz);
  std::vector<Joint> mapped;
  for (const auto& entry : planned.mapping.joints) mapped.push_back(entry.joint);
  if (has_truth) {
    planned.truth_has_z_up = planned.take.up_axis == UpAxis::z;
    check_up_axis(planned, mapped);
  }
  planned.ok = true;
}

}  // namespace trilat
