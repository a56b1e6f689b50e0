// SPDX-License-Identifier: MIT
#include "pipeline/gate/finding.h"

#include <array>

namespace trilat {

const char* name_of(FindingKind kind) {
  constexpr std::array<const char*, 5> kNames{"accuracy", "coverage", "status", "failure", "number"};
  return kNames.at(static_cast<std::size_t>(kind));
}

const char* name_of(Direction direction) {
  constexpr std::array<const char*, 3> kNames{"worse", "better", "changed"};
  return kNames.at(static_cast<std::size_t>(direction));
}

}  // namespace trilat
