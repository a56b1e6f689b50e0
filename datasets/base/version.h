// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace trilat {

// Name and version of this program, as it goes into every file it makes.
inline constexpr const char* kProgramVersion = "trilat 0.5.0";

// Which build of the program this is: the hash of its file. Work that two builds share would not be known to
// be the same.
std::string build_id();

}  // namespace trilat
