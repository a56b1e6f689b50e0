// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/session/session_reader.h"

namespace trilat {

// Tells recordings apart without reading all of them: a hash of how long the file is, of what the sensors
// are, of every time stamp and clock exchange, and of one depth frame in 1200.
std::string fingerprint_of(const SessionReader& session);

}  // namespace trilat
