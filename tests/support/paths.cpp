// SPDX-License-Identifier: MIT
#include "tests/support/paths.h"

namespace trilat {

const char* const kSourceDir = TRILAT_SOURCE_DIR;
const char* const kProgram = TRILAT_BINARY;
const char* const kAgentProgram = TRILAT_AGENT_BINARY;

}  // namespace trilat
