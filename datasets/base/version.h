// SPDX-License-Identifier: MIT
#pragma once

namespace trilat {

// Name and version of this program, as it goes into every file it makes.
inline constexpr const char* kProgramVersion = "trilat 0.1.0";

}  // namespace trilat
