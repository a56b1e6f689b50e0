// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "datasets/session/session_types.h"

namespace trilat {

// Why a reader of sessions would not believe this sensor; empty where it would.
std::string refusal_of(const SensorDescription& sensor);

// Whether a reader would believe these times: within 18 years of their clock's origin, exchanges within 9.
bool is_plausible(const FrameStamp& stamp, std::int64_t tick_ns);
bool is_plausible(const ClockExchange& exchange);

}  // namespace trilat
