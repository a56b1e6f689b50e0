// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/stream_fit/stream_fit.h"

namespace trilat {

// What the subject and the reference are called, and how what was found is applied. Remedies are those of a
// file of joints.
struct StreamWords {
  std::string reference = "the truth";
  std::vector<std::string> names;  // of the points
  bool clock_is_applied = false;   // the start that the motion shows
};

// What was found, with its size, the mean distance before and after it was applied, and how to apply it;
// empty for a sound subject. Several changes that are not told apart are listed without a remedy.
std::string stream_note(const StreamFit& fit, const StreamWords& words);

}  // namespace trilat
