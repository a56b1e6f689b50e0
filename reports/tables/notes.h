// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace trilat {

// The sentences that stand under a table: those of a section of notes.md.
std::vector<std::string> notes(const std::string& section);

}  // namespace trilat
