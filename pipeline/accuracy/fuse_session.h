// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "datasets/export/fused_path.h"
#include "datasets/results/studies/tracking_summary.h"
#include "datasets/results/summary.h"
#include "pipeline/accuracy/methods/method_spec.h"
#include "pipeline/study/watch.h"

namespace trilat {

struct FusedSession {
  FusedPath path = {};
  std::vector<std::string> sensors;
  RayRow rays;
  std::vector<TakeNote> notes;
  double answered = 0.0;  // share of instants and joints
};

// One person of a session by one method, without any ground truth: the one whom its sensors see most. All
// joints, from the first to the last body frame of any sensor. InputError as a study's take; Interrupted when
// asked to stop.
FusedSession fuse_session(const std::filesystem::path& session, const std::filesystem::path& calibration,
                          const MethodSpec& method, double rate_hz, const Watch& watch);

}  // namespace trilat
