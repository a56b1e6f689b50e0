// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/session/session_types.h"

namespace trilat {

// Why a reader of sessions would not believe this sensor; empty where it would.
std::string refusal_of(const SensorDescription& sensor);

}  // namespace trilat
