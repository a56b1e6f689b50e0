// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/results/gate_history.h"
#include "pipeline/gate/finding.h"
#include "pipeline/gate/judge_cells.h"

namespace trilat {

// The name of what a finding is about, the same every night.
std::string key_of(const GateFinding& finding);
// And of the series that shows it, as in HistoryEntry::error_m.
std::string series_of(const std::string& study, const std::string& method, const std::string& condition,
                      const std::string& group);

struct HistoryJudgement {
  std::vector<GateFinding> drifts;
  std::uint64_t nights = 0;  // since the last accepted change, without tonight
};

// Sets "since when" of tonight's findings, and finds levels that moved away slowly: by change points of each
// series since the last accepted change, tonight at its end. A drift is a last stretch of at least
// kFewestDriftNights whose level is further from the first stretch's than the smallest effect (of speed
// kSmallestSpeedDrift_percent), by more than chance would have it: Student's t on the noise around the
// levels, corrected for the places of the change points and by Holm for all series, at kDriftShare of the
// night's chance; of what is not an alarm tonight anyway. Slower, less accurate and answering less is an
// alarm. `accepted_time`: when the baseline was accepted; nights before count as little as those before a
// line that says so. Empty: not known.
inline constexpr std::size_t kFewestDriftNights = 4;
inline constexpr double kSmallestSpeedDrift_percent = 3.0;
inline constexpr double kDriftShare = 0.1;
HistoryJudgement judge_history(const History& history, const HistoryEntry& tonight, const GateLimits& limits,
                               std::vector<GateFinding>& findings, const std::string& accepted_time = "");

}  // namespace trilat
