// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

namespace trilat {

enum class NumberMeaning : std::uint8_t { more_is_worse, less_is_worse, unknown, not_judged };

// What a number of a summary says of quality, by the words its key is made of (separated by '_', matched
// whole). Ends of intervals, standard errors and what describes a bootstrap are not judged.
NumberMeaning meaning_of_key(const std::string& key);

}  // namespace trilat
