// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace trilat {

enum class ChunkCompression { none, blosc, deflate };

inline constexpr int kBloscFilter = 32001;  // the number registered with the HDF Group
// How many numbers Blosc's filter is told, and which of them is the size of a chunk.
inline constexpr std::size_t kBloscValues = 7, kBloscChunkBytes = 3;
inline constexpr int kDeflateFilter = 1;
inline constexpr int kChunkLevel = 1;  // of either compression

// The quickest compression that this build has: Blosc, or else deflate.
ChunkCompression quickest_compression();

// One chunk as it goes to the file: compressed, with HDF5's fletcher32 checksum behind. Pure: any thread may
// call it. Blosc is Zstandard level 1 with bit shuffle; deflate is level 1. `none` only adds the checksum.
std::vector<std::byte> encode_chunk(std::span<const std::byte> raw, std::size_t element_bytes,
                                    ChunkCompression compression);

// Decompresses into exactly raw.size() bytes and never more; false when there are not so many, or the stream
// is damaged.
bool decompress_bytes(std::span<const std::byte> data, ChunkCompression compression,
                      std::span<std::byte> raw);

// The raw bytes of a chunk made by encode_chunk(). False when the checksum or the compressed stream is
// damaged, or the chunk does not hold raw.size() bytes. Pure: any thread may call it.
bool decode_chunk(std::span<const std::byte> chunk, ChunkCompression compression, std::span<std::byte> raw);

}  // namespace trilat
