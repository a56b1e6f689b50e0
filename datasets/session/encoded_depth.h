// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "datasets/hdf5/chunk_codec.h"
#include "datasets/session/session_types.h"

namespace trilat {

// One depth frame ready for the file. Made by encode_depth_frame() on any thread.
struct EncodedDepthFrame {
  FrameStamp stamp;
  std::vector<std::byte> chunk;
  ChunkCompression compression = ChunkCompression::blosc;
};

// `depth_mm` holds kDepthPixels values, row by row, exactly as received; 0 is invalid.
EncodedDepthFrame encode_depth_frame(const FrameStamp& stamp, std::span<const std::uint16_t> depth_mm,
                                     ChunkCompression compression);

}  // namespace trilat
