// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace trilat {

// The values of a 16-bit grey PNG of 512 x 424 pixels, as they are written, into kDepthPixels. InputError for
// another size, depth or colour; TornRow for a damaged file.
void read_depth_png(const std::filesystem::path& path, std::span<std::uint16_t> values);

}  // namespace trilat
