// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
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

// The values of a 16-bit grey PNG of 512 x 424 pixels, as they are written, into kDepthPixels. InputError for
// another size, depth or colour; TornRow for a damaged file.
void read_depth_png(const std::filesystem::path& path, std::span<std::uint16_t> values);

}  // namespace trilat
