// SPDX-License-Identifier: MIT
#include "datasets/session/encoded_depth.h"

#include "datasets/base/check.h"

namespace trilat {

EncodedDepthFrame encode_depth_frame(const FrameStamp& stamp, std::span<const std::uint16_t> depth_mm,
                                     ChunkCompression compression) {
  TRILAT_CHECK(depth_mm.size() == kDepthPixels, "a depth frame has 512 x 424 pixels");
  return {stamp, encode_chunk(std::as_bytes(depth_mm), 2, compression), compression};
}

}  // namespace trilat
