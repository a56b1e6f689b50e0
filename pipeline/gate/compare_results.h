// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>

#include "pipeline/gate/gate_report.h"
#include "pipeline/gate/judge_cells.h"

namespace trilat {

struct CompareOptions {
  GateLimits limits;
  std::function<bool()> stop_requested = {};
};

// Everything of a gate but the history: finds both nights' results, refuses what cannot be compared
// (InputError), compares each study exactly first and in numbers where it differs, and judges all together.
GateReport compare_results(const std::filesystem::path& results, const std::filesystem::path& baseline,
                           const CompareOptions& options);

}  // namespace trilat
