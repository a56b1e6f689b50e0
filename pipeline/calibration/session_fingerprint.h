// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/session/session_reader.h"

namespace trilat {

// Tells recordings apart without reading all of them: a hash of what the sensors are, of every time stamp and
// clock exchange, of how many bytes the depth frames take, and of one frame in 600.
std::string fingerprint_of(const SessionReader& session);

}  // namespace trilat
