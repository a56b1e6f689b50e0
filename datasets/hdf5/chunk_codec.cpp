// SPDX-License-Identifier: MIT
#include "datasets/hdf5/chunk_codec.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include <blosc.h>
#include <hdf5.h>
#include <zlib.h>

#include "datasets/base/check.h"

namespace trilat {
namespace {

constexpr int kLevel = 1;
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
    const int written = blosc_compress_ctx(kLevel, BLOSC_BITSHUFFLE, values[2], byte_count, *buffer, result,
                                           result_size, BLOSC_ZSTD_COMPNAME, 0, 1);
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

// The checksum that HDF5's fletcher32 filter expects: big-endian 16-bit words, sums folded to 16
// bits.
std::uint32_t fletcher32(std::span<const std::byte> data) {
  std::uint32_t low = 0, high = 0;
  const auto fold = [](std::uint32_t sum) { return (sum & 0xffff) + (sum >> 16); };
  std::size_t i = 0;
  const std::size_t words = data.size() / 2;
  for (std::size_t word = 0; word < words;) {
    const std::size_t stop = std::min(words, word + 360);
    for (; word < stop; ++word, i += 2) {
      low += std::to_integer<std::uint32_t>(data[i]) << 8 | std::to_integer<std::uint32_t>(data[i + 1]);
      high += low;
    }
    low = fold(low);
    high = fold(high);
  }
  if (data.size() % 2) {
    low += std::to_integer<std::uint32_t>(data.back()) << 8;
    high += low;
    low = fold(low);
    high = fold(high);
  }
  return fold(high) << 16 | fold(low);
}

std::vector<std::byte> blosc_bytes(std::span<const std::byte> raw, std::size_t element_bytes) {
  std::vector<std::byte> out(raw.size() + BLOSC_MAX_OVERHEAD);
  const int written = blosc_compress_ctx(kLevel, BLOSC_BITSHUFFLE, element_bytes, raw.size(), raw.data(),
                                         out.data(), out.size(), BLOSC_ZSTD_COMPNAME, 0, 1);
  TRILAT_CHECK(written > 0, "Blosc compresses into a large enough buffer");
  out.resize(static_cast<std::size_t>(written));
  return out;
}

std::vector<std::byte> deflate_bytes(std::span<const std::byte> raw) {
  uLongf size = compressBound(raw.size());
  std::vector<std::byte> out(size);
  TRILAT_CHECK(compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                         reinterpret_cast<const Bytef*>(raw.data()), raw.size(), kLevel) == Z_OK,
               "zlib compresses into a large enough buffer");
  out.resize(size);
  return out;
}

}  // namespace

void register_blosc_filter() {
  static const H5Z_class2_t filter = {H5Z_CLASS_T_VERS, kBloscFilter, 1,       1,
                                      "blosc",          nullptr,      nullptr, blosc_filter};
  TRILAT_CHECK(H5Zregister(&filter) >= 0, "HDF5 takes the Blosc filter");
}

std::vector<unsigned int> filter_values_of(ChunkCompression compression, std::size_t element_bytes,
                                           std::size_t chunk_bytes) {
  if (compression == ChunkCompression::deflate) return {kLevel};
  if (compression == ChunkCompression::none) return {};
  return {kFilterRevision,
          BLOSC_VERSION_FORMAT,
          static_cast<unsigned int>(element_bytes),
          static_cast<unsigned int>(chunk_bytes),
          kLevel,
          BLOSC_BITSHUFFLE,
          BLOSC_ZSTD};
}

std::vector<std::byte> encode_chunk(std::span<const std::byte> raw, std::size_t element_bytes,
                                    ChunkCompression compression) {
  std::vector<std::byte> out = compression == ChunkCompression::blosc ? blosc_bytes(raw, element_bytes)
                               : compression == ChunkCompression::deflate
                                   ? deflate_bytes(raw)
                                   : std::vector(raw.begin(), raw.end());
  const std::uint32_t sum = fletcher32(out);
  for (int byte = 0; byte < 4; ++byte) out.push_back(static_cast<std::byte>(sum >> (8 * byte) & 0xff));
  return out;
}

bool decode_chunk(std::span<const std::byte> chunk, ChunkCompression compression, std::span<std::byte> raw) {
  if (chunk.size() < 4) return false;
  const std::span<const std::byte> data = chunk.first(chunk.size() - 4);
  std::uint32_t stored = 0;
  for (std::size_t byte = 0; byte < 4; ++byte)
    stored |= std::to_integer<std::uint32_t>(chunk[data.size() + byte]) << (8 * byte);
  if (fletcher32(data) != stored) return false;
  if (compression == ChunkCompression::blosc) {
    std::size_t size = 0;
    return blosc_cbuffer_validate(data.data(), data.size(), &size) >= 0 && size == raw.size() &&
           blosc_decompress_ctx(data.data(), raw.data(), raw.size(), 1) == static_cast<int>(raw.size());
  }
  if (compression == ChunkCompression::deflate) {
    uLongf size = raw.size();
    return uncompress(reinterpret_cast<Bytef*>(raw.data()), &size,
                      reinterpret_cast<const Bytef*>(data.data()), data.size()) == Z_OK &&
           size == raw.size();
  }
  if (data.size() != raw.size()) return false;
  std::copy(data.begin(), data.end(), raw.begin());
  return true;
}

}  // namespace trilat
