// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>

#include "datasets/results/gate_history.h"
#include "pipeline/gate/found_results.h"
#include "pipeline/gate/gate_report.h"

namespace trilat {

// Mean errors (m) that a history keeps of accuracy studies: one for each method and condition, averaged over
// the joint groups, under the study's first alignment.
std::map<std::string, double> mean_errors_of(const ResultsSet& results);

// The name of what a finding is about, the same every night; a history keeps it of each alarm.
std::string key_of(const GateFinding& finding);

// Sets "since when" of the report's alarms: the first of the nights in a row, up to the report's, that raised
// the same alarm. Returns how many nights there are since the last accepted change, without the report's.
// Nights before the report's baseline was accepted do not count. Without any night nothing is set.
std::size_t set_since(std::span<const Night> history, GateReport& report);

}  // namespace trilat
