// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace trilat {

// Which build of the program this is, as hexadecimal digits: the linker's build id, which is a hash of the
// program's contents. Equal sources, compilers and options give equal ids; work that two builds share would
// not be known to be the same.
std::string build_id();

}  // namespace trilat
