// SPDX-License-Identifier: MIT
#include "evaluators/wand/wand_sighting.h"

#include <array>

namespace trilat {

std::string name_of(WandStatus status) {
  static constexpr std::array<const char*, 7> kNames{
      "not_looked", "found", "no_wand", "several_candidates", "out_of_range", "cut_by_edge", "not_ended"};
  return kNames.at(static_cast<std::size_t>(status));
}

}  // namespace trilat
