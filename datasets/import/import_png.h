// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "datasets/import/import_types.h"

namespace trilat {

// A folder of depth images to a session of one sensor. The unit, and where the times come from, must be said.
ImportReport import_png(const std::vector<std::filesystem::path>& files, const std::filesystem::path& output,
                        const ImportOptions& options);

// The last number in a file's name without its ending, such as 12.25 in depth-12.25; nothing when there is
// none.
std::optional<double> last_number_in(std::string_view stem);

}  // namespace trilat
