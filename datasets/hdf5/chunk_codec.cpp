// SPDX-License-Identifier: MIT
#include "datasets/hdf5/chunk_codec.h"

#include <algorithm>

#include <zlib.h>

#include "datasets/base/error.h"
#include "datasets/hdf5/blosc_codec.h"

namespace trilat {
namespace {

// The checksum that HDF5's fletcher32 filter expects: big-endian 16-bit words, sums folded to 16 bits.
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

// Checksum in the last four bytes of a chunk, which has at least these.
std::uint32_t stored_checksum(std::span<const std::byte> chunk) {
  std::uint32_t sum = 0;
  for (std::size_t byte = 0; byte < 4; ++byte)
    sum |= std::to_integer<std::uint32_t>(chunk[chunk.size() - 4 + byte]) << (8 * byte);
  return sum;
}

std::vector<std::byte> deflate_bytes(std::span<const std::byte> raw) {
  uLongf size = compressBound(raw.size());
  std::vector<std::byte> out(size);
  TRILAT_CHECK(compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                         reinterpret_cast<const Bytef*>(raw.data()), raw.size(), kChunkLevel) == Z_OK,
               "zlib compresses into a large enough buffer");
  out.resize(size);
  return out;
}

}  // namespace

ChunkCompression quickest_compression() {
  return has_blosc() ? ChunkCompression::blosc : ChunkCompression::deflate;
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

bool decompress_bytes(std::span<const std::byte> data, ChunkCompression compression,
                      std::span<std::byte> raw) {
  if (compression == ChunkCompression::blosc) return unblosc_bytes(data, raw);
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

bool decode_chunk(std::span<const std::byte> chunk, ChunkCompression compression, std::span<std::byte> raw) {
  if (chunk.size() < 4) return false;
  const std::span<const std::byte> data = chunk.first(chunk.size() - 4);
  return fletcher32(data) == stored_checksum(chunk) && decompress_bytes(data, compression, raw);
}

}  // namespace trilat
