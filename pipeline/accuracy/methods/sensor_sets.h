// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

namespace trilat {

// Sets of `size` of `sensors` sensors, each in rising order: all of them, in lexicographic order, when they
// are `most` or fewer. Otherwise `most` different ones, which are the first sensors of random orders of all:
// order n is the same for every size, so that a set of one size lies within one of the next. Both numbers
// are at least 1, `size` at most `sensors`.
std::vector<std::vector<std::size_t>> sensor_sets(std::size_t sensors, std::size_t size, std::size_t most);

}  // namespace trilat
