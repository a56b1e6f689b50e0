// SPDX-License-Identifier: MIT
#pragma once

// TRILAT_CHECK(condition, "what must hold"): always on, throws InternalError with the source line.
// For our own mistakes only; what comes from outside is refused with InputError.
#define TRILAT_CHECK(condition, what)                                   \
  do {                                                                  \
    if (!(condition)) ::trilat::check_failed(__FILE__, __LINE__, what); \
  } while (false)

namespace trilat {

[[noreturn]] void check_failed(const char* file, int line, const char* what);

}  // namespace trilat
