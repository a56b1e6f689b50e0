// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/depth_occlusion.h"

#include <algorithm>
#include <atomic>

#include "datasets/base/error.h"
#include "datasets/session/clock/session_clock.h"
#include "evaluators/bodies/occlusion.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);
constexpr std::size_t kBatch = 32;  // frames read ahead, then decoded on all threads

// For every instant the number of the depth frame nearest in time.
std::vector<std::size_t> nearest_frames(const PlannedTake& planned, const SessionReader& session,
                                        std::size_t sensor, const std::vector<HostTime>& time) {
  const std::size_t number = planned.session_sensor[sensor];
  const SensorDescription& description = session.header().sensors[number];
  const std::uint64_t frames = session.counts(number).depth_frames;
  if (frames == 0)
    throw InputError(
        session.path().string() + ":/sensors/" + description.name,
        "holds no depth frames, by which occlusion \"depth\" would see what is hidden; use \"corrected\"");
  std::vector<std::pair<HostTime, std::size_t>> exposures;
  for (const FrameStamp& stamp : session.stamps(number, FrameStream::depth, 0, frames))
    exposures.emplace_back(planned.host_from_sensor[sensor](stamp), exposures.size());
  std::ranges::sort(exposures);
  const Duration reach = duration_from_s(0.5 / description.nominal_rate_hz);
  std::vector<std::size_t> nearest;
  for (const HostTime t : time) {
    std::size_t best = kNone;
    Duration least = reach;
    for (auto it = std::ranges::lower_bound(exposures, std::pair(t - reach, std::size_t{0}));
         it != exposures.end() && it->first <= t + reach; ++it) {
      const Duration off = std::max(it->first - t, t - it->first);
      if (off > least) continue;
      least = off;
      best = it->second;
    }
    nearest.push_back(best);
  }
  return nearest;
}

}  // namespace

OcclusionCounts find_hidden(const Plan& plan, const PlannedTake& planned, const SessionReader& session,
                            const std::function<bool()>& stop_requested, const TakeData& data) {
  OcclusionCounts hidden(data.time.size(), plan.rig.size());
  for (std::size_t s = 0; s < plan.rig.size(); ++s) {
    const std::size_t number = planned.session_sensor[s];
    const DepthIntrinsics& intrinsics = session.header().sensors[number].intrinsics;
    const std::vector<std::size_t> nearest = nearest_frames(planned, session, s, data.time);
    for (std::size_t first = 0; first < nearest.size(); first += kBatch) {
      if (stop_requested && stop_requested()) throw Interrupted();
      const std::size_t count = std::min(kBatch, nearest.size() - first);
      std::vector<StoredDepthFrame> frames(count);  // the HDF5 library is read by one thread
      for (std::size_t k = 0; k < count; ++k)
        if (nearest[first + k] != kNone) frames[k] = session.stored_depth_frame(number, nearest[first + k]);
      parallel_for_index(count, 1, [&](std::size_t k) {
        if (nearest[first + k] == kNone) return;
        std::vector<std::uint16_t> depth_mm(kDepthPixels);
        decode_depth_frame(frames[k], depth_mm);
        const auto of_joint =
            depth_hidden(data.bodies.at(first + k, s), {kDepthWidth, kDepthHeight, depth_mm}, intrinsics, {});
        for (std::size_t j = 0; j < kJointCount; ++j) hidden.at(first + k, s, j) = of_joint[j] ? 1 : 0;
      });
    }
  }
  return hidden;
}

}  // namespace trilat
