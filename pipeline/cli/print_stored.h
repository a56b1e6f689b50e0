// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace trilat {

// Prints the stored title, tables, findings and warnings of a study on stdout. Only the first tables are
// printed, cut to the width of a terminal; with `all` every table that a report shows is printed whole.
void print_stored(const std::filesystem::path& results, bool all = false);

}  // namespace trilat
