// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "pipeline/sweep/sweep_spec.h"

namespace trilat {

inline const std::string kOneRig = R"("rigs": [{"name": "a", "heights_m": [0.3, 2.3, 0.3, 2.3]}])";

// A sweep with these members beside its name.
inline SweepSpec sweep_of(const std::string& members) {
  const std::string text =
      R"({"format": "trilat.study", "version": 1, "kind": "threshold_sweep", "name": "test", )" + members +
      "}";
  return parse_sweep(parse_json(text, "sweep.json"), "sweep.json");
}

}  // namespace trilat
