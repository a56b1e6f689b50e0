// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "pipeline/accuracy/methods/method.h"

namespace trilat {

// A kind of method: a row of the table. Adding one takes its solver and a row; its settings are a member of
// MethodSpec.
struct MethodKind {
  std::string_view name;  // in studies
  std::string_view what;
  std::string_view source;  // equation or paper
  bool needs_ranges;        // it sees the joint's distances; else its positions in the world
  bool calibrates = false;  // its calibration is estimated unless a study says otherwise
  std::size_t sensors = 0;  // it uses just so many; 0: any number
  void (*settings)(Fields& f, MethodSpec& spec) = nullptr;  // its own; null when it has none
  // One of both: an instant by itself, seen by some sensors; or whole paths.
  PointEstimate (*evaluate)(const Method& method, const JointInstant& instant, SensorMask sensors) = nullptr;
  OverTimeSolver over_time = nullptr;
  // Many instants side by side, where that is faster.
  void (*evaluate_many)(const Method& method, std::span<const JointInstant> instants,
                        std::span<PointEstimate> estimates) = nullptr;
};

const std::vector<MethodKind>& method_kinds();
// The kind of methods that takes bring. No study names it, and it has no solver.
const MethodKind& external_kind();
// InternalError when there is none of that name.
const MethodKind& method_kind(std::string_view name);

}  // namespace trilat
