// SPDX-License-Identifier: MIT
#include "datasets/hdf5/blosc_codec.h"

#include <blosc.h>

#include "datasets/base/error.h"
#include "datasets/hdf5/chunk_codec.h"

namespace trilat {

bool has_blosc() { return true; }

std::vector<std::byte> blosc_bytes(std::span<const std::byte> raw, std::size_t element_bytes) {
  std::vector<std::byte> out(raw.size() + BLOSC_MAX_OVERHEAD);
  const int written = blosc_compress_ctx(kChunkLevel, BLOSC_BITSHUFFLE, element_bytes, raw.size(), raw.data(),
                                         out.data(), out.size(), BLOSC_ZSTD_COMPNAME, 0, 1);
  TRILAT_CHECK(written > 0, "Blosc compresses into a large enough buffer");
  out.resize(static_cast<std::size_t>(written));
  return out;
}

bool unblosc_bytes(std::span<const std::byte> data, std::span<std::byte> raw) {
  std::size_t size = 0;
  return blosc_cbuffer_validate(data.data(), data.size(), &size) >= 0 && size == raw.size() &&
         blosc_decompress_ctx(data.data(), raw.data(), raw.size(), 1) == static_cast<int>(raw.size());
}

}  // namespace trilat
