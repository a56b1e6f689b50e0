// SPDX-License-Identifier: MIT
#pragma once

namespace trilat {

// Absolute paths of this clone and build. They stand in one source, so that a compiler cache knows all others
// again in another clone.
extern const char* const kSourceDir;
extern const char* const kProgram;  // trilat
extern const char* const kAgentProgram;

}  // namespace trilat
