// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/mocap/motive_header.h"

namespace trilat {

// Fills the assets of `header` from the rows between the keys and the row of axes ("Frame,Time,X,
// …"), which stands at `place`. Rows are known by the label in their second cell, or, without
// labels, by their order: type, name, ID, kind.
MotiveLayout read_motive_columns(const std::vector<std::vector<std::string>>& rows,
                                 const std::vector<std::string>& axes, const std::string& place,
                                 MocapHeader& header);

}  // namespace trilat
