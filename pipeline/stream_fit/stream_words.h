// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/stream_fit/stream_fit.h"
#include "pipeline/stream_fit/stream_jump.h"

namespace trilat {

// Names that a note uses, and whether the start was applied already. Remedies are those of a file of joints.
struct StreamWords {
  std::string reference = "the truth";
  std::vector<std::string> names;  // of the points
  bool clock_is_applied = false;   // the start that the motion shows
};

// "1000", "39.3701" of a unit, "1.15" of another scale.
std::string factor_text(const SizeChange& size);
// ", as feet taken for metres" of a unit, else nothing.
const char* unit_text(const SizeChange& size);
// "(x, z, -y)" for a matrix of signed axes.
std::string axes_text(const Eigen::Matrix3d& axes);
// "has left and right exchanged", or which points stand under the names of others.
std::string order_text(const StreamChange& change, const std::vector<std::string>& names);

// The note on a fit: each cause with its size, the mean distance before and after it was applied, and how to
// apply it; empty for a sound subject. Changes that are not told apart are listed without a remedy.
std::string stream_note(const StreamFit& fit, const StreamWords& words);
// The note on a clock that jumps.
std::string jump_note(const ClockJump& jump, double before_m, const StreamWords& words);
// The note on a change in a part.
std::string part_note(const PartChange& part, double before_m, const StreamWords& words);
// The note on points that differ by a constant each.
std::string own_places_note(double after_m, double before_m, const StreamWords& words);
// The note on a frame that moves.
std::string drift_note(const FrameDrift& drift, double before_m, const StreamWords& words);

}  // namespace trilat
