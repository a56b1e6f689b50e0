// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/base/strict_json.h"
#include "datasets/session/session_reader.h"

namespace trilat {

// How a sensor's clock stands on the host clock, for `trilat info --json`; {"problem": …} when it cannot be
// placed.
Json clock_json(const SessionReader& session, std::size_t sensor);

}  // namespace trilat
