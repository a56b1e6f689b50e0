// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>

#include "datasets/results/gate_history.h"
#include "pipeline/gate/found_results.h"
#include "pipeline/gate/gate_report.h"

namespace trilat {

// Adds what a history keeps of results to `entry`: error and coverage of every cell of accuracy studies, of
// the first alignment.
void add_series(const ResultsSet& results, HistoryEntry& entry);

// The name of what a finding is about, the same every night; a history keeps it of each alarm.
std::string key_of(const GateFinding& finding);

// Sets "since when" of the report's alarms: the first of the nights in a row, up to the report's, that raised
// the same alarm. Returns how many nights there are since the last accepted change, without the report's.
// Nights before the report's baseline was accepted do not count. Without any night nothing is set.
std::size_t set_since(const History& history, GateReport& report);

}  // namespace trilat
