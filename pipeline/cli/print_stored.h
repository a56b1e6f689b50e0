// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace trilat {

// Prints on stdout what a study stored for its readers: what it is about, its first tables as far as they fit
// a terminal (or with `all` all of those that a report shows, whole), findings and warnings.
void print_stored(const std::filesystem::path& results, bool all = false);

}  // namespace trilat
