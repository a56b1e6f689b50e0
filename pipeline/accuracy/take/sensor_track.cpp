// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/sensor_track.h"

#include <algorithm>
#include <utility>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlockRows = 512;

ObservedBody observed(const Body& body) {
  ObservedBody result;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (reading_of(body, j) != JointReading::seen) continue;
    result.joint_in_sensor_m[j] = Eigen::Map<const Eigen::Vector3f>(body.position_m[j].data());
    result.state[j] = static_cast<TrackingState>(body.tracking_state[j]);
  }
  return result;
}

// Whether left and right are exchanged from one frame to the next: mirrored, the later body is far nearer to
// the earlier one.
bool changes_sides(const ObservedBody& a, const ObservedBody& b) {
  double unmirrored_m = 0.0, mirrored_m = 0.0;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto mirror = static_cast<std::size_t>(mirror_of(static_cast<Joint>(j)));
    if (mirror == j || !a.has(j) || !b.has(j) || !b.has(mirror)) continue;
    unmirrored_m += static_cast<double>((a.joint_in_sensor_m[j] - b.joint_in_sensor_m[j]).norm());
    mirrored_m += static_cast<double>((a.joint_in_sensor_m[j] - b.joint_in_sensor_m[mirror]).norm());
  }
  return mirrored_m < 0.5 * unmirrored_m;
}

// Linear, but never across a change of sides, of which no exchange could be undone any more: there it is the
// nearer frame.
ObservedBody between(const ObservedBody& a, const ObservedBody& b, double share) {
  if (changes_sides(a, b)) return share < 0.5 ? a : b;
  ObservedBody result;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (!a.has(j) || !b.has(j)) continue;
    const Eigen::Vector3d from = a.joint_in_sensor_m[j].cast<double>();
    result.joint_in_sensor_m[j] =
        (from + share * (b.joint_in_sensor_m[j].cast<double>() - from)).cast<float>();
    result.state[j] = std::min(a.state[j], b.state[j]);
  }
  return result;
}

ObservedBody chosen_body(const SensorFrame& frame, const std::set<std::uint64_t>* wanted) {
  const IdentifiedBody* best = nullptr;
  std::ptrdiff_t most = -1;
  for (const IdentifiedBody& seen : frame.bodies) {
    if (wanted && !wanted->contains(seen.identity)) continue;
    const auto tracked = std::ranges::count(seen.body.state, TrackingState::tracked);
    if (tracked > most) {
      most = tracked;
      best = &seen;
    }
  }
  return best ? best->body : ObservedBody{};
}

// Removes bodies by number, of frames that end at these bodies.
void remove(const std::vector<std::size_t>& numbers, std::vector<IdentifiedBody>& bodies,
            std::vector<std::size_t>& end_of_frame) {
  std::vector<bool> is_removed(bodies.size());
  for (const std::size_t number : numbers) is_removed[number] = true;
  std::size_t kept = 0, next = 0;
  for (std::size_t& end : end_of_frame) {
    for (; next < end; ++next)
      if (!is_removed[next]) bodies[kept++] = bodies[next];
    end = kept;
  }
  bodies.resize(kept);
}

}  // namespace

SensorBodies read_sensor_bodies(const SessionReader& session, std::size_t sensor,
                                const SensorClockMap& host_from_sensor,
                                const std::function<bool()>& stop_requested) {
  const std::uint64_t rows = session.counts(sensor).body_frames;
  SensorBodies result;
  std::vector<SensorFrame>& frames = result.frames;
  frames.reserve(rows);
  result.bodies.reserve(session.counts(sensor).bodies);
  std::vector<std::size_t> end_of_frame;  // in the bodies
  BodyIdentities identities;
  StaleBodies repeated;
  for (std::uint64_t first = 0; first < rows; first += kBlockRows) {
    if (stop_requested && stop_requested()) throw Interrupted();
    for (const BodyFrame& row : session.body_frames(sensor, first, std::min(kBlockRows, rows - first))) {
      SensorFrame frame{host_from_sensor(row.stamp), host_from_sensor.agent({row.stamp.arrival_ns}), {}};
      if (!frames.empty() && frame.time <= frames.back().time) {
        ++result.not_later;
        continue;
      }
      const std::vector<std::uint64_t> identity =
          identities.of(row.bodies, (frame.time - HostTime{0}).seconds());
      for (std::size_t b = 0; b < row.bodies.size(); ++b) {
        repeated.add(row.bodies[b], result.bodies.size());
        result.joints.add(row.bodies[b]);
        result.bodies.push_back({identity[b], observed(row.bodies[b])});
      }
      end_of_frame.push_back(result.bodies.size());
      frames.push_back(frame);
    }
  }
  if (const std::vector<std::size_t> stale = repeated.finish(); !stale.empty()) {
    result.stale = stale.size();
    remove(stale, result.bodies, end_of_frame);
  }
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const std::size_t begin = f == 0 ? 0 : end_of_frame[f - 1];
    frames[f].bodies = std::span(result.bodies).subspan(begin, end_of_frame[f] - begin);
  }
  result.jumps = identities.jumps();
  return result;
}

ObservedBody body_at(std::span<const SensorFrame> frames, HostTime t, Duration longest_gap,
                     const std::set<std::uint64_t>* wanted) {
  const auto after = std::ranges::lower_bound(
      frames, t, [](HostTime a, HostTime b) { return a < b; }, &SensorFrame::time);
  if (after == frames.end()) return {};
  if (after->time == t) return chosen_body(*after, wanted);
  if (after == frames.begin()) return {};
  const SensorFrame& before = *(after - 1);
  if (after->time - before.time > longest_gap) return {};
  const double share =
      static_cast<double>((t - before.time).ns) / static_cast<double>((after->time - before.time).ns);
  return between(chosen_body(before, wanted), chosen_body(*after, wanted), share);
}

ObservedBody newest_body(std::span<const SensorFrame> frames, HostTime t, Duration longest_gap, Duration late,
                         const std::set<std::uint64_t>* wanted) {
  auto frame = std::ranges::upper_bound(
      frames, t, [](HostTime a, HostTime b) { return a < b; }, &SensorFrame::time);
  while (frame != frames.begin()) {
    --frame;
    if (t - frame->time > longest_gap) return {};
    if (frame->arrived <= t && frame->arrived - frame->time <= late) return chosen_body(*frame, wanted);
  }
  return {};
}

}  // namespace trilat
