// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace trilat {

// Computes a tiny study of every kind into folders inside `scratch`, and parts of studies into
// `scratch`/parts.
void write_sound_results(const std::filesystem::path& scratch);

}  // namespace trilat
