// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace trilat {

// "converged 99.8 %, too_few_ranges 0.2 %", the most frequent first.
std::string statuses_text(const std::map<std::string, std::uint64_t>& statuses, std::uint64_t asked);

}  // namespace trilat
