// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/base/strict_json.h"
#include "datasets/results/tracking_summary.h"

namespace trilat {

// The rows of tracking.json. Readers refuse counts that contradict each other.
Json json_of(const ViewRow& row);
Json json_of(const ExchangeRow& row);
Json json_of(const ClockRow& row);
ViewRow read_view(JsonObject& object);
ExchangeRow read_exchange(JsonObject& object);
ClockRow read_clock(JsonObject& object);

}  // namespace trilat
