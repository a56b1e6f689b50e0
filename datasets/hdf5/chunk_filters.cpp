// SPDX-License-Identifier: MIT
#include <cstdlib>

#include <blosc.h>
#include <hdf5.h>

#include "datasets/base/error.h"
#include "datasets/hdf5/chunk_codec.h"

namespace trilat {
namespace {

constexpr unsigned int kFilterRevision = 2;
// No chunk of ours is larger; a file that claims more is hostile.
constexpr std::size_t kMaxChunkBytes = 256u << 20;

// HDF5 calls this to read (and, through the library, to write) chunks. `buffer` is the library's,
// from malloc.
std::size_t blosc_filter(unsigned int flags, std::size_t value_count, const unsigned int values[],
                         std::size_t byte_count, std::size_t* buffer_size, void** buffer) {
  void* result = nullptr;
  std::size_t result_size = 0;
  if (flags & H5Z_FLAG_REVERSE) {
    std::size_t compressed = 0, block = 0;
    if (blosc_cbuffer_validate(*buffer, byte_count, &result_size) < 0 || result_size > kMaxChunkBytes)
      return 0;
    blosc_cbuffer_sizes(*buffer, &result_size, &compressed, &block);
    result = std::malloc(result_size ? result_size : 1);
    if (!result) return 0;
    if (blosc_decompress_ctx(*buffer, result, result_size, 1) < 0) {
      std::free(result);
      return 0;
    }
  } else {
    if (value_count < 3 || values[2] == 0) return 0;
    result_size = byte_count + BLOSC_MAX_OVERHEAD;
    result = std::malloc(result_size);
    if (!result) return 0;
    const int written = blosc_compress_ctx(kChunkLevel, BLOSC_BITSHUFFLE, values[2], byte_count, *buffer,
                                           result, result_size, BLOSC_ZSTD_COMPNAME, 0, 1);
    if (written <= 0) {
      std::free(result);
      return 0;
    }
    byte_count = static_cast<std::size_t>(written);
  }
  const std::size_t used = flags & H5Z_FLAG_REVERSE ? result_size : byte_count;
  std::free(*buffer);
  *buffer = result;
  *buffer_size = result_size;
  return used;
}

}  // namespace

void register_blosc_filter() {
  static const H5Z_class2_t filter = {H5Z_CLASS_T_VERS, kBloscFilter, 1,       1,
                                      "blosc",          nullptr,      nullptr, blosc_filter};
  TRILAT_CHECK(H5Zregister(&filter) >= 0, "HDF5 takes the Blosc filter");
}

std::vector<unsigned int> filter_values_of(ChunkCompression compression, std::size_t element_bytes,
                                           std::size_t chunk_bytes) {
  if (compression == ChunkCompression::deflate) return {kChunkLevel};
  if (compression == ChunkCompression::none) return {};
  return {kFilterRevision,
          BLOSC_VERSION_FORMAT,
          static_cast<unsigned int>(element_bytes),
          static_cast<unsigned int>(chunk_bytes),
          kChunkLevel,
          BLOSC_BITSHUFFLE,
          BLOSC_ZSTD};
}

}  // namespace trilat
