// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace trilat {

// The Blosc part of encode_chunk() and decode_chunk(), which not every build has.
bool has_blosc();
// InternalError where there is no Blosc.
std::vector<std::byte> blosc_bytes(std::span<const std::byte> raw, std::size_t element_bytes);
// False where the bytes are damaged, do not hold raw.size() bytes, or there is no Blosc.
bool unblosc_bytes(std::span<const std::byte> data, std::span<std::byte> raw);

}  // namespace trilat
