// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/truth_track.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/mocap/read_mocap.h"
#include "evaluators/alignment/clock_offset.h"
#include "evaluators/alignment/interpolation.h"
#include "evaluators/fusion/baselines.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr double kTruthRate_hz = 60.0;  // dense enough for movements smoothed over 60 ms
constexpr double kGrid_hz = 120.0;
// Longest lag of a tracker behind the body: Kinect v2 bodies arrive some 60 ms late in all.
constexpr double kMaxLag_s = 0.1;
constexpr double kNoticeable_m = 0.005;  // mean speed times what the lag does not explain

void check_stop(std::size_t i, const std::function<bool()>& stop_requested) {
  constexpr std::size_t kPeriod = 256;
  if (i % kPeriod == 0 && stop_requested && stop_requested()) throw Interrupted();
}

// With room for so many points.
std::vector<PointPath> empty_paths(const Plan& plan, std::size_t points) {
  std::vector<PointPath> paths(plan.joints.size());
  for (PointPath& path : paths) {
    path.time_s.reserve(points);
    path.position_m.reserve(points);
  }
  return paths;
}

// Seconds since the first instant, on the host clock.
std::vector<PointPath> estimated_paths(const Plan& plan, const PlannedTake& planned,
                                       const PreparedTake& data) {
  std::vector<PointPath> paths = empty_paths(plan, data.time.size());
  std::vector<JointObservation> seen(plan.rig.size());
  for (std::size_t i = 0; i < data.time.size(); ++i)
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      observe_joint(data, i, plan.joints[j], planned.world_from_sensor, seen);
      paths[j].time_s.push_back((data.time[i] - data.time.front()).seconds());
      paths[j].position_m.push_back(solve_mean(seen, {}).position_m);
    }
  return paths;
}

// So far beyond both ends as the clock is searched.
std::vector<PointPath> true_paths(const Plan& plan, const PlannedTake& planned, const MarkerTrack& truth,
                                  const std::function<bool()>& stop_requested) {
  const double margin_s = plan.study.clock_search_s + 3.0 * ClockOffsetOptions{}.slow_s;
  std::vector<Eigen::Vector3d> joints(plan.joints.size());
  const double length_s = plan.instant(planned.instants - 1).seconds() + 2.0 * margin_s;
  const auto count = static_cast<std::size_t>(length_s * kTruthRate_hz) + 1;
  std::vector<PointPath> paths = empty_paths(plan, count);
  for (std::size_t k = 0; k < count; ++k) {
    check_stop(k, stop_requested);
    const double since_s = static_cast<double>(k) / kTruthRate_hz - margin_s;
    const HostTime t = planned.start + duration_from_s(since_s);
    truth.at({(t - HostTime{planned.take.mocap_start_host_ns}).ns}, joints);
    for (std::size_t j = 0; j < joints.size(); ++j) {
      paths[j].time_s.push_back(since_s);
      paths[j].position_m.push_back(joints[j]);
    }
  }
  return paths;
}

// The stated start in another unit, where the export then holds some of the session's time; else what the
// recording's clock showed.
std::string start_remedy(const PlannedTake& planned, HostTime last, Duration export_length) {
  struct Unit {
    const char* name;
    std::int64_t ns;
  };
  const std::int64_t stated = planned.take.mocap_start_host_ns;
  for (const Unit& unit :
       {Unit{"seconds", 1'000'000'000}, {"milliseconds", 1'000'000}, {"microseconds", 1'000}}) {
    if (std::abs(stated) > std::numeric_limits<std::int64_t>::max() / unit.ns) continue;
    const HostTime start{stated * unit.ns};
    if (start < last && planned.start < start + export_length)
      return fmt::format("; it would hold the session's time if {} were {}: write {}", stated, unit.name,
                         start.ns);
  }
  return fmt::format(
      "; the recording's clock ran from {} to {} ns: what did it show at the export's first frame?",
      planned.start.ns, last.ns);
}

[[noreturn]] void refuse_without_truth(const Plan& plan, const PlannedTake& planned,
                                       const MarkerTrack& truth) {
  const double start_s = (planned.start - HostTime{planned.take.mocap_start_host_ns}).seconds();
  const Duration length = plan.instant(planned.instants - 1);
  if (start_s < Duration{truth.end().ns}.seconds() && start_s + length.seconds() > 0.0)
    throw InputError(
        planned.take.mocap.string(),
        fmt::format("has frames from {:.3f} s to {:.3f} s on its clock, while the session runs, but no "
                    "joint in any of them: all assets of a joint must be there. Are they labelled, "
                    "and does the mapping name the right ones?",
                    std::max(0.0, start_s),
                    std::min(Duration{truth.end().ns}.seconds(), start_s + length.seconds())));
  throw InputError(
      planned.take.mocap.string(),
      fmt::format(
          "holds no ground truth for the time of the session: on the mocap's clock the session runs "
          "from {:.3f} s to {:.3f} s and the export from 0 s to {:.3f} s (mocap_start_host_ns is {}){}",
          start_s, start_s + length.seconds(), static_cast<double>(truth.end().ns) * 1e-9,
          planned.take.mocap_start_host_ns, start_remedy(planned, planned.start + length, {truth.end().ns})));
}

// Warning of a clock offset that the trackers' lag does not explain; empty when there is none.
std::string warning_of(const ClockOffset& found, const StudySpec& study) {
  if (found.status == ClockOffsetStatus::no_agreement && std::isfinite(found.median_distance_m))
    return fmt::format(
        "lies {:.1f} m from where the sensors see the joints, at every start within {:g} s of the stated one "
        "that fits their speeds; is the calibration in its world, and mocap_start_host_ns right?",
        found.median_distance_m, study.clock_search_s);
  if (found.status == ClockOffsetStatus::no_agreement || found.status == ClockOffsetStatus::at_limit)
    return fmt::format(
        "does not move as the sensors see the person move, at any start within {:g} s of the stated one; is "
        "it the same take, and mocap_start_host_ns right?",
        study.clock_search_s);
  if (found.status != ClockOffsetStatus::found) return {};
  const double lowest_s = -(kMaxLag_s + study.clock_error_s), highest_s = study.clock_error_s;
  const double beyond_s = std::max({0.0, lowest_s - found.high_s, found.low_s - highest_s});
  if (beyond_s * found.speed_m_s < kNoticeable_m) return {};
  return fmt::format(
      "starts {:.4f} s ({:.4f} to {:.4f}) {} than stated, by the motion: more than trackers lag. {}",
      std::abs(found.offset_s), std::min(std::abs(found.low_s), std::abs(found.high_s)),
      std::max(std::abs(found.low_s), std::abs(found.high_s)), found.offset_s > 0.0 ? "earlier" : "later",
      study.clock == ClockSource::motion
          ? std::string("That offset was applied")
          : fmt::format("At the joints' mean speed of {:.2f} m/s that makes errors of {:.0f} cm; mend "
                        "mocap_start_host_ns, or say \"clock\": \"motion\" in the study",
                        found.speed_m_s, 100.0 * std::abs(found.offset_s) * found.speed_m_s));
}

}  // namespace

MarkerTrack truth_of(const PlannedTake& planned, const std::vector<Joint>& joints, Duration longest_gap,
                     MocapTime until) {
  const MocapHeader header = read_mocap_header(planned.take.mocap);
  const std::string place = planned.take.mapping.string() + " /joints/";
  std::vector<std::string> names;
  std::vector<std::vector<std::size_t>> assets;
  for (const Joint joint : joints) {
    names.emplace_back(name_of(joint));
    assets.emplace_back();
    for (const auto& entry : planned.mapping.joints)
      if (entry.joint == joint) assets.back() = assets_of_joint(header, entry.assets, place + names.back());
  }
  refuse_same_assets(names, assets, place);
  std::set<std::size_t> wanted;
  for (const std::vector<std::size_t>& of_joint : assets) wanted.insert(of_joint.begin(), of_joint.end());
  const MocapPart part{.assets = {{wanted.begin(), wanted.end()}}, .until = until};
  return {read_positions(planned.take.mocap, part), std::move(assets), longest_gap, planned.truth_has_z_up};
}

SampledTruth sample_truth(const Plan& plan, const PlannedTake& planned, Duration offset, bool densely,
                          const std::function<bool()>& stop_requested) {
  const MarkerTrack track = truth_of(planned, plan.joints, duration_from_s(plan.study.truth_gap_s));
  SampledTruth truth;
  const Duration mocap_start{planned.take.mocap_start_host_ns - offset.ns};
  const std::size_t joints = plan.joints.size();
  truth.at_instants_m.resize(planned.instants * joints);
  for (std::uint64_t i = 0; i < planned.instants; ++i) {
    check_stop(i, stop_requested);
    track.at({(planned.start + plan.instant(i) - mocap_start).ns},
             std::span(truth.at_instants_m).subspan(i * joints, joints));
  }
  if (std::ranges::none_of(truth.at_instants_m, [](const auto& p) { return p.allFinite(); }))
    refuse_without_truth(plan, planned, track);
  if (densely) truth.dense = true_paths(plan, planned, track, stop_requested);
  truth.oddities = suspicious_names(track);
  return truth;
}

std::string cause_of(const std::string& status) {
  const auto is = [&](ClockOffsetStatus one) { return status == name_of(one); };
  if (is(ClockOffsetStatus::too_little_motion))
    return "the joints hardly move, in it or as the sensors see them; if the person did move, its numbers "
           "have another unit than its header says, such as metres under Millimeters";
  if (is(ClockOffsetStatus::no_agreement))
    return "its joints do not move as the sensors see them move at any start that was looked at; is it this "
           "take and this person? The files of two persons may be exchanged";
  if (is(ClockOffsetStatus::ambiguous)) return "several starts fit, as when somebody walks in a circle";
  if (is(ClockOffsetStatus::at_limit)) return "the best start lies at the end of the search; look farther";
  if (is(ClockOffsetStatus::too_uncertain)) return "the movements are too few to say it closely";
  return "nothing was compared";
}

MotionClock clock_by_motion(const Plan& plan, const PlannedTake& planned, const PreparedTake& data,
                            const std::vector<PointPath>& truth) {
  ClockOffsetOptions options;
  options.grid_hz = kGrid_hz;
  options.search_s = plan.study.clock_search_s;
  options.frames = !planned.in_mocap_world                   ? StreamFrames::turned
                   : compares_absolute_positions(plan.study) ? StreamFrames::same
                                                             : StreamFrames::shifted;
  const ClockOffset found = find_clock_offset(estimated_paths(plan, planned, data), truth, options);
  ClockOffsetRow row;
  row.status = name_of(found.status);
  row.offset_s = found.offset_s;
  row.low_s = found.low_s;
  row.high_s = found.high_s;
  row.drift_ppm = found.drift_ppm;
  row.drift_sigma_ppm = found.drift_sigma_ppm;
  row.peak = found.peak;
  row.second = found.second;
  return {row, warning_of(found, plan.study)};
}

}  // namespace trilat
