// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_views.h"

#include <algorithm>
#include <array>
#include <atomic>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/session/clock/session_clock.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 60;  // frames that are searched one after the other, apart from all others

// Sightings in neighbouring depth frames of one sensor.
struct SearchedBlock {
  std::size_t sensor = 0;
  std::uint64_t first = 0, count = 0;
  std::vector<TimedSighting> found;  // in the order of time
  std::map<std::string, std::uint64_t> statuses;
};

// Tables that all frames of a sensor share.
struct SearchedSensor {
  DepthRays rays;
  SensorClockMap host_from_sensor;
};

void search(const SessionReader& session, const SearchedSensor& sensor, const WandSearchOptions& options,
            SearchedBlock& block) {
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  const std::vector<FrameStamp> stamps =
      session.stamps(block.sensor, FrameStream::depth, block.first, block.count);
  std::optional<Eigen::Vector3d> before_m;
  for (std::uint64_t i = 0; i < block.count; ++i) {
    options.control.check();
    decode_depth_frame(session.stored_depth_frame(block.sensor, block.first + i), depth_mm);
    if (i % options.whole_image_every == 0) before_m.reset();
    const DepthImageView image{kDepthWidth, kDepthHeight, depth_mm};
    const WandSighting sighting = follow_wand(image, sensor.rays, options.find, before_m);
    ++block.statuses[name_of(sighting.status)];
    if (sighting.status == WandStatus::found)
      block.found.push_back({sensor.host_from_sensor(stamps[i]), sighting});
  }
}

// Sightings in all depth frames, sensor by sensor in their order.
std::vector<SearchedBlock> search_all(const SessionReader& session, const WandSearchOptions& options) {
  std::vector<SearchedSensor> sensors(session.header().sensors.size());
  std::vector<SearchedBlock> blocks;
  std::uint64_t all = 0;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    const std::uint64_t frames = session.counts(s).depth_frames;
    sensors[s] = {depth_rays(session.header().sensors[s].intrinsics), fit_sensor_clock(session, s)};
    for (std::uint64_t first = 0; first < frames; first += kBlock)
      blocks.push_back({s, first, std::min(kBlock, frames - first), {}, {}});
    all += frames;
  }
  std::atomic<std::uint64_t> done{0};
  parallel_for_index(blocks.size(), 1, [&](std::size_t b) {
    search(session, sensors[blocks[b].sensor], options, blocks[b]);
    options.control.report(static_cast<double>(done += blocks[b].count) / static_cast<double>(all));
  });
  return blocks;
}

void add_rests(SensorEvidence& evidence, const std::vector<StaticSighting>& rests) {
  for (const StaticSighting& ball : rests) {
    const double distance_m = ball.centre_in_sensor_m.norm();
    evidence.nearest_m = evidence.rests == 0 ? distance_m : std::min(evidence.nearest_m, distance_m);
    evidence.farthest_m = std::max(evidence.farthest_m, distance_m);
    ++evidence.rests;
  }
}

// A diameter is easily taken for a radius: tries half and twice the stated one in some frames.
std::optional<double> other_radius_m(const SessionReader& session, std::size_t sensor, FindWandOptions find) {
  constexpr std::uint64_t kLooks = 40;
  constexpr std::size_t kMinFound = 8, kTimesStated = 3;
  const DepthRays rays = depth_rays(session.header().sensors[sensor].intrinsics);
  const std::uint64_t frames = session.counts(sensor).depth_frames;
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  const double stated_m = find.ball_radius_m;
  const std::array radii_m{stated_m, 0.5 * stated_m, 2.0 * stated_m};
  std::array<std::size_t, radii_m.size()> found{};
  for (std::uint64_t i = 0; i < frames; i += 1 + frames / kLooks) {
    decode_depth_frame(session.stored_depth_frame(sensor, i), depth_mm);
    for (std::size_t r = 0; r < radii_m.size(); ++r) {
      find.ball_radius_m = radii_m[r];
      const WandSighting sighting = find_wand({kDepthWidth, kDepthHeight, depth_mm}, rays, find);
      found[r] += sighting.status == WandStatus::found ? 1 : 0;
    }
  }
  const std::size_t best = found[1] > found[2] ? 1 : 2;
  if (found[best] < kMinFound || found[best] <= kTimesStated * found[0]) return std::nullopt;
  return radii_m[best];
}

void add_recording(WandObservations& views, const SessionReader& session, const ViewWandOptions& options) {
  std::vector<std::vector<TimedSighting>> found(views.evidence.size());
  for (const SearchedBlock& block : search_all(session, options.search)) {
    SensorEvidence& evidence = views.evidence[block.sensor];
    evidence.frames += block.count;
    for (const auto& [status, count] : block.statuses) evidence.statuses[status] += count;
    for (const TimedSighting& sighting : block.found)  // only what rises in time
      if (auto& all = found[block.sensor]; all.empty() || all.back().time < sighting.time)
        all.push_back(sighting);
  }
  std::vector<StaticSighting> rests;
  for (std::size_t s = 0; s < found.size(); ++s) {
    const std::vector<StaticSighting> more = find_static_intervals(found[s], s, options.positions);
    add_rests(views.evidence[s], more);
    views.evidence[s].doubt = doubt_about(session.header().sensors[s].intrinsics);
    if (views.evidence[s].rests == 0)
      views.evidence[s].other_radius_m = other_radius_m(session, s, options.search.find);
    rests.insert(rests.end(), more.begin(), more.end());
  }
  // One recording at a time: the host clocks of two need not be the same.
  auto positions = find_wand_positions(std::move(rests), options.positions);
  views.positions.insert(views.positions.end(), positions.begin(), positions.end());
  views.simulated = views.simulated || session.header().simulated;
}

// Whether a sensor that saw both saw the ball in one place.
bool are_one_place(const WandPosition& a, const WandPosition& b, double within_m) {
  for (const StaticSighting& one : a.seen)
    for (const StaticSighting& other : b.seen)
      if (one.sensor == other.sensor)
        return (one.centre_in_sensor_m - other.centre_in_sensor_m).norm() < within_m;
  return false;
}

void check_depth(const SessionReader& session) {
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    const SensorDescription& sensor = session.header().sensors[s];
    const std::string place = session.path().string() + ":/sensors/" + sensor.name;
    if (session.counts(s).depth_frames == 0)
      throw InputError(place,
                       "has no depth frames, in which the wand could be found; `--method bodies` needs none");
    if (sensor.intrinsics.width_px != kDepthWidth || sensor.intrinsics.height_px != kDepthHeight)
      throw InputError(place, fmt::format("says that its image has {} x {} pixels; depth frames have {} x {}",
                                          sensor.intrinsics.width_px, sensor.intrinsics.height_px,
                                          kDepthWidth, kDepthHeight));
  }
}

bool are_of_one_rig(const SessionReader& a, const SessionReader& b) {
  return std::ranges::equal(a.header().sensors, b.header().sensors, {}, &SensorDescription::name,
                            &SensorDescription::name);
}

}  // namespace

WandObservations view_wand(std::span<const SessionReader> sessions, const ViewWandOptions& options) {
  for (const SessionReader& session : sessions) {  // all of them before minutes of work
    check_depth(session);
    if (!are_of_one_rig(sessions.front(), session))
      throw InputError(session.path().string(),
                       "has other sensors than the first session; all recordings must be of one rig");
  }
  WandObservations views;
  for (const SensorDescription& sensor : sessions.front().header().sensors)
    views.evidence.push_back({.name = sensor.name, .statuses = {}});
  for (std::size_t r = 0; r < sessions.size(); ++r) {
    add_recording(views, sessions[r], options);
    if (r == 0) views.positions_of_first = views.positions.size();
  }
  return views;
}

HostTime start_of_depth(const SessionReader& session) {
  std::optional<HostTime> start;
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    if (session.counts(s).depth_frames == 0) continue;
    const HostTime first = fit_sensor_clock(session, s)(session.stamps(s, FrameStream::depth, 0, 1).front());
    start = start ? std::min(*start, first) : first;
  }
  if (!start) throw InputError(session.path().string(), "has no depth frames");
  return *start;
}

std::vector<bool> sensors_that_saw(const WandObservations& views) {
  std::vector<bool> saw(views.evidence.size(), false);
  for (const WandPosition& position : views.positions)
    for (const StaticSighting& ball : position.seen) saw[ball.sensor] = true;
  return saw;
}

// Places that only one sensor saw do not show where it stands beside the others, and a hand that drifts
// may make two rests of one place.
void drop_unusable_positions(WandObservations& views) {
  constexpr double kSamePlace_m = 0.05;
  std::vector<WandPosition> kept;
  std::size_t kept_of_first = 0;
  for (std::size_t p = 0; p < views.positions.size(); ++p) {
    const WandPosition& position = views.positions[p];
    const bool again = !kept.empty() && are_one_place(kept.back(), position, kSamePlace_m);
    if (again || (position.seen.size() < 2 && views.evidence.size() > 1)) continue;
    kept.push_back(position);
    if (p < views.positions_of_first) kept_of_first = kept.size();
  }
  views.positions = std::move(kept);
  views.positions_of_first = kept_of_first;
}

std::optional<double> seen_movement_m(const WandObservations& views) {
  double sum_m = 0.0, count = 0.0;
  for (const StaticSighting& first : views.positions[0].seen)
    for (const StaticSighting& second : views.positions[1].seen)
      if (first.sensor == second.sensor) {
        sum_m += (second.centre_in_sensor_m - first.centre_in_sensor_m).norm();
        count += 1.0;
      }
  if (count == 0.0) return std::nullopt;
  return sum_m / count;
}

}  // namespace trilat
