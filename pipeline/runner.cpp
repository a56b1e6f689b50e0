// SPDX-License-Identifier: MIT
#include "pipeline/runner.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/results/samples.h"
#include "pipeline/parallel.h"
#include "pipeline/sensor_track.h"
#include "pipeline/truth_track.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 256;    // instants gathered before they are solved together
constexpr std::uint64_t kTogether = 16;  // instants that one thread solves side by side

class Stopwatch {
 public:
  explicit Stopwatch(std::atomic<std::int64_t>& total_ns) : total_ns_(total_ns) {}
  ~Stopwatch() { total_ns_ += (std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::atomic<std::int64_t>& total_ns_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

struct Shared {
  const Plan& plan;
  const RunOptions& options;
  SamplesFile& writer;
  std::uint64_t total_instants = 0;
  std::atomic<std::uint64_t> done_instants{0};
  std::atomic<bool> stopped{false};
  std::atomic<std::int64_t> read_ns{0}, solve_ns{0}, write_ns{0};

  bool must_stop() {
    if (options.stop_requested && options.stop_requested()) stopped = true;
    return stopped;
  }
};

// One take's inputs, opened for one pass.
struct OpenTake {
  SessionReader session;
  std::vector<SensorTrack> sensors;
  TruthTrack truth;

  OpenTake(const Plan& plan, const PlannedTake& planned)
      : session(planned.take.session),
        truth(planned.take.mocap, planned.mapping, planned.take.mapping, plan.joints,
              duration_from_s(plan.study.truth_gap_s)) {
    for (std::size_t s = 0; s < plan.rig.size(); ++s)
      sensors.emplace_back(session, planned.session_sensor[s], planned.host_from_sensor[s], plan.joints,
                           duration_from_s(plan.study.sensor_gap_s));
  }
};

// What the rig saw during a block: per instant and joint, one observation a sensor.
struct Observations {
  std::size_t sensors = 0, joints = 0;
  std::vector<JointObservation> values;
  std::span<const JointObservation> of(std::uint64_t instant, std::size_t joint) const {
    return {&values[(instant * joints + joint) * sensors], sensors};
  }
};

struct TakeCheck {
  std::uint64_t samples = 0, disagreements = 0;
  double worst_m = 0.0;
  std::string worst_at, disagreed_at;  // the first
  void merge(const TakeCheck& later) {
    samples += later.samples;
    disagreements += later.disagreements;
    if (disagreed_at.empty()) disagreed_at = later.disagreed_at;
    if (later.worst_m > worst_m) {
      worst_m = later.worst_m;
      worst_at = later.worst_at;
    }
  }
};

void gather(const Plan& plan, const PlannedTake& planned, OpenTake& take, SampleBlock& block,
            Observations& seen) {
  std::vector<SensorJoint> joints(plan.joints.size());
  std::vector<Eigen::Vector3d> truth(plan.joints.size());
  const Duration mocap_start{planned.take.mocap_start_host_ns};
  for (std::uint64_t i = 0; i < block.instants; ++i) {
    const HostTime t = planned.start + plan.instant(block.first_instant + i);
    block.time_ns[i] = t.ns;
    for (std::size_t s = 0; s < plan.rig.size(); ++s) {
      take.sensors[s].observe(t, joints);
      for (std::size_t j = 0; j < joints.size(); ++j)
        seen.values[(i * seen.joints + j) * seen.sensors + s] =
            joints[j].seen
                ? observe(joints[j].point_in_sensor_m, joints[j].state, planned.world_from_sensor[s])
                : JointObservation{};
    }
    take.truth.at({(t - mocap_start).ns}, truth);
    for (std::size_t j = 0; j < joints.size(); ++j)
      for (int axis = 0; axis < 3; ++axis)
        block.truth_m[(i * joints.size() + j) * 3 + static_cast<std::size_t>(axis)] = truth[j][axis];
  }
}

void store(SampleBlock& block, std::size_t slot, const PointEstimate& estimate) {
  for (int axis = 0; axis < 3; ++axis)
    block.estimate_m[slot * 3 + static_cast<std::size_t>(axis)] = estimate.position_m[axis];
  block.status[slot] = static_cast<std::uint8_t>(estimate.status);
  block.iterations[slot] = static_cast<std::uint32_t>(std::max(0, estimate.iterations));
  block.cost_m2[slot] = estimate.cost_m2;
  block.gdop[slot] = static_cast<float>(estimate.gdop);
}

// Every method on a few instants, which are few enough to stay in the cache.
void solve_instants(const Plan& plan, const PlannedTake& planned, const Observations& seen,
                    std::uint64_t first, std::uint64_t last, SampleBlock& block) {
  std::vector<JointInstant> instants;
  instants.reserve((last - first) * plan.joints.size());
  const std::uint64_t first_row = first * plan.joints.size();
  for (std::uint64_t i = first; i < last; ++i)
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      const auto observations = seen.of(i, j);
      instants.push_back(
          {observations, planned.world_from_sensor, ranges_of(observations, planned.world_from_sensor)});
      block.ranges[first_row + instants.size() - 1] = static_cast<std::uint8_t>(instants.back().ranges.count);
    }
  std::vector<PointEstimate> estimates(instants.size());
  for (std::size_t m = 0; m < plan.methods.size(); ++m) {
    evaluate(plan.methods[m], instants, estimates);
    for (std::size_t k = 0; k < estimates.size(); ++k)
      store(block, (first_row + k) * plan.methods.size() + m, estimates[k]);
  }
}

// The method that is held against Ceres: the first nonlinear one with damping lm and the step rule.
const Method* checked_method(const Plan& plan) {
  for (const Method& m : plan.methods)
    if (m.spec.kind == MethodKind::nonlinear && m.spec.nonlinear.damping == Damping::lm &&
        m.spec.nonlinear.stop == StopRule::step && m.spec.nonlinear.loss == Loss::squares)
      return &m;
  return nullptr;
}

TakeCheck cross_check_instant(const Plan& plan, const PlannedTake& planned, const Observations& seen,
                              std::uint64_t i, const Method& method, std::uint64_t number) {
  TakeCheck check;
  for (std::size_t j = 0; j < plan.joints.size(); ++j) {
    const auto observations = seen.of(i, j);
    const RangeProblem ranges = ranges_of(observations, planned.world_from_sensor, method.allowed);
    const PointEstimate ours = solve_nonlinear(ranges, method.spec.nonlinear);
    const PointEstimate theirs = solve_ceres(ranges, method.spec.ceres);
    TakeCheck one;
    one.worst_at = fmt::format("{} instant {} {}", planned.take.id, number, name_of(plan.joints[j]));
    if (is_usable(ours.status) && is_usable(theirs.status)) {
      one.samples = 1;
      one.worst_m = (ours.position_m - theirs.position_m).norm();
    } else if (is_usable(ours.status) != is_usable(theirs.status)) {
      one.disagreements = 1;
      one.disagreed_at = one.worst_at;
    }
    check.merge(one);
  }
  return check;
}

[[noreturn]] void refuse_without_truth(const Plan& plan, const PlannedTake& planned, TruthTrack& truth) {
  const double start_s = (planned.start - HostTime{planned.take.mocap_start_host_ns}).seconds();
  throw InputError(
      planned.take.mocap.string(),
      fmt::format("holds no ground truth for the time of the session: on the mocap's clock the session "
                  "runs from {:.3f} s to {:.3f} s and the export from 0 s to {:.3f} s "
                  "(mocap_start_host_ns is {})",
                  start_s, start_s + plan.instant(planned.instants - 1).seconds(),
                  static_cast<double>(truth.read_to_end().ns) * 1e-9, planned.take.mocap_start_host_ns));
}

void note_state(const OpenTake& take, const PlannedTake& planned, std::vector<TakeNote>& notes) {
  const std::string& id = planned.take.id;
  std::uint64_t several = 0;
  for (const SensorTrack& sensor : take.sensors) several += sensor.frames_with_several_bodies();
  if (several > 0)
    notes.push_back(
        {id, false, planned.take.session.string(),
         fmt::format("{} frames hold several bodies; the one with the most tracked joints was taken",
                     several)});
  if (take.truth.samples_frozen() > 0)
    notes.push_back({id, false, planned.take.mocap.string(),
                     fmt::format("{} samples stand still to the last digit or lie exactly at the origin and "
                                 "were not used as ground truth",
                                 take.truth.samples_frozen())});
  const MocapAnomalies& odd = take.truth.anomalies();
  if (odd.truncated_last_row || odd.repeated_frames > 0 || odd.partial_poses > 0)
    notes.push_back(
        {id, false, planned.take.mocap.string(),
         fmt::format("{}{} repeated frames and {} incomplete poses were left out; `trilat mocap` says more",
                     odd.truncated_last_row ? "is cut off in its last row; " : "", odd.repeated_frames,
                     odd.partial_poses)});
  if (!planned.span_note.empty())
    notes.push_back({id, false, planned.take.session.string(), planned.span_note});
  if (odd.printed_time_differs > 0)
    notes.push_back(
        {id, false, planned.take.mocap.string(),
         fmt::format("{} printed times are more than a frame off what frame number and rate give; is the "
                     "export's frame rate right?",
                     odd.printed_time_differs)});
  if (!take.session.complete())
    notes.push_back({id, false, planned.take.session.string(), "was not closed by its recorder"});
}

// Places are given from the campaign's folder, so that results do not depend on where they were computed.
TakeNote within_campaign(TakeNote note, const Campaign& campaign) {
  const std::string folder = campaign.folder.empty() ? "" : (campaign.folder / "").string();
  for (std::string* text : {&note.place, &note.text})
    for (auto at = text->find(folder); !folder.empty() && at != std::string::npos; at = text->find(folder))
      text->erase(at, folder.size());
  return note;
}

struct TakeOutcome {
  std::vector<TakeNote> notes;
  TakeCheck check;
  bool evaluated = false;
};

void evaluate_take(Shared& shared, std::size_t index, TakeOutcome& outcome) {
  const Plan& plan = shared.plan;
  const PlannedTake& planned = plan.takes[index];
  OpenTake take(plan, planned);
  const Method* checked = shared.options.cross_check ? checked_method(plan) : nullptr;
  SampleBlock block;
  Observations seen{plan.rig.size(), plan.joints.size(), {}};
  bool any_truth = false, any_seen = false;
  for (std::uint64_t first = 0; first < planned.instants; first += kBlock) {
    if (shared.must_stop()) throw Interrupted();
    const std::uint64_t count = std::min(kBlock, planned.instants - first);
    block.reset(first, count, plan.joints.size(), plan.methods.size());
    seen.values.resize(count * seen.joints * seen.sensors);
    {
      const Stopwatch watch(shared.read_ns);
      gather(plan, planned, take, block, seen);
    }
    any_truth |=
        std::any_of(block.truth_m.begin(), block.truth_m.end(), [](double v) { return std::isfinite(v); });
    any_seen |= std::any_of(seen.values.begin(), seen.values.end(),
                            [](const JointObservation& observation) { return observation.seen; });
    std::vector<TakeCheck> checks(checked ? count : 0);
    {
      const Stopwatch watch(shared.solve_ns);
      parallel_for_index((count + kTogether - 1) / kTogether, 1, [&](std::size_t part) {
        const std::uint64_t from = part * kTogether, to = std::min(count, from + kTogether);
        solve_instants(plan, planned, seen, from, to, block);
        for (std::uint64_t i = from; checked && i < to; ++i)
          checks[i] = cross_check_instant(plan, planned, seen, i, *checked, first + i);
      });
    }
    for (const TakeCheck& check : checks) outcome.check.merge(check);
    {
      const Stopwatch watch(shared.write_ns);
      shared.writer.write(index, block);
    }
    if (shared.options.progress)
      shared.options.progress(static_cast<double>(shared.done_instants += count) /
                              static_cast<double>(shared.total_instants));
  }
  if (!any_truth) refuse_without_truth(plan, planned, take.truth);
  if (!any_seen)
    throw InputError(
        planned.take.session.string(),
        "no sensor ever sees a joint that is asked for: there are no bodies, or all positions are "
        "untracked or not finite");
  note_state(take, planned, outcome.notes);
  outcome.evaluated = true;
}

// Fills all slots of a take with "not solved".
void write_empty(const Plan& plan, std::size_t index, SamplesFile& writer) {
  SampleBlock block;
  const std::uint64_t instants = plan.takes[index].instants;
  for (std::uint64_t first = 0; first < instants; first += kBlock) {
    block.reset(first, std::min(kBlock, instants - first), plan.joints.size(), plan.methods.size());
    writer.write(index, block);
  }
}

void run_take(Shared& shared, std::size_t index, TakeOutcome& outcome) {
  const PlannedTake& planned = shared.plan.takes[index];
  try {
    if (!planned.ok) throw InputError(planned.place, planned.problem);
    evaluate_take(shared, index, outcome);
  } catch (const OutputError&) {
    throw;
  } catch (const InputError& error) {
    outcome.notes.push_back({planned.take.id, true, error.place(), error.problem()});
    outcome.check = {};
    write_empty(shared.plan, index, shared.writer);
  } catch (const Interrupted&) {
    shared.stopped = true;
  }
}

}  // namespace

SamplesHeader samples_header(const Plan& plan) {
  SamplesHeader header;
  for (Joint joint : plan.joints) header.joints.emplace_back(name_of(joint));
  for (const Method& method : plan.methods) header.methods.push_back(method.spec.name);
  for (int s = 0; s < kSolveStatusCount; ++s)
    header.status_names.emplace_back(name_of(static_cast<SolveStatus>(s)));
  header.alignment = name_of(plan.study.alignments.front());
  for (const PlannedTake& take : plan.takes) header.takes.push_back({take.take.id, take.instants});
  return header;
}

RunOutcome run_plan(const Plan& plan, SamplesFile& samples, const RunOptions& options) {
  const Method* checked = options.cross_check ? checked_method(plan) : nullptr;
  if (options.cross_check && !checked)
    throw InputError(
        "study \"" + plan.study.name + '"',
        "has no nonlinear method with damping lm and stop step that could be checked against Ceres");
  Shared shared{plan, options, samples};
  for (const PlannedTake& take : plan.takes) shared.total_instants += take.instants;
  std::vector<TakeOutcome> outcomes(plan.takes.size());
  parallel_for_index(plan.takes.size(), 1, [&](std::size_t t) { run_take(shared, t, outcomes[t]); });
  if (shared.stopped) throw Interrupted();
  RunOutcome result;
  TakeCheck check;
  for (const TakeOutcome& outcome : outcomes) {
    for (const TakeNote& note : outcome.notes) result.notes.push_back(within_campaign(note, plan.campaign));
    result.evaluated.push_back(outcome.evaluated);
    check.merge(outcome.check);
  }
  if (checked)
    result.cross_check = CrossCheck{checked->spec.name,
                                    check.samples,
                                    check.disagreements,
                                    check.worst_m,
                                    plan.study.cross_check_limit_m,
                                    check.disagreements > 0 ? check.disagreed_at : check.worst_at};
  const auto seconds = [](const std::atomic<std::int64_t>& ns) {
    return static_cast<double>(ns.load()) * 1e-9;
  };
  result.times = {seconds(shared.read_ns), seconds(shared.solve_ns), seconds(shared.write_ns), 0.0};
  return result;
}

}  // namespace trilat
