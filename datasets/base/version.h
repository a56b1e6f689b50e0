// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace trilat {

// Name and version of this program, as it goes into every file it makes.
inline constexpr const char* kProgramVersion = "trilat 0.1.0";

// Which build of the program this is, as hexadecimal digits: the linker's build id, which is a hash of the
// program's contents. Equal sources, compilers and options give equal ids; work that two builds share would
// not be known to be the same.
std::string build_id();

}  // namespace trilat
