// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/gate/found_results.h"

namespace trilat {

// Where two documents differ: JSON pointer and both values as text ("nothing" where one has none).
struct JsonDifference {
  std::string pointer, now, before;
};
std::vector<JsonDifference> json_differences(const Json& now, const Json& before);

// What may differ between two runs of one configuration: the program's version, hashes that follow from the
// study, and what the code under test makes of the inputs. What is left must be equal.
Json configuration_of(const Json& manifest);

// InputError that names the places and both values when the configurations differ, or the recorded inputs do.
// A simulation's recordings are results of the code and may differ.
void check_same_configuration(const ResultsPair& pair);

// Whether every input has the same content; true when there are none.
bool same_inputs(const Json& now, const Json& before);

}  // namespace trilat
