// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/session/session_types.h"

namespace trilat {

// The cells of a line between single commas, or between runs of blanks; an empty cell behind the last comma
// is none. Views into `line`.
std::vector<std::string_view> comma_cells(std::string_view line);
std::vector<std::string_view> blank_cells(std::string_view line);

// Each throws TornRow naming `what` when the cell is not such a number.
double number_in(std::string_view cell, std::string_view what);
std::int64_t integer_in(std::string_view cell, std::string_view what);
std::uint64_t id_in(std::string_view cell, std::string_view what);
// An integer in [0, limit].
std::uint8_t small_number_in(std::string_view cell, std::string_view what, int limit);

// A state between the SDK's is InputError: somebody averaged or resampled the file.
std::uint8_t tracking_state_of(double value, const std::string& place);

// InputError when a joint lies beyond 20 m, which no Kinect sees: another unit than metres.
void check_positions(const Body& body, const std::string& place);

}  // namespace trilat
