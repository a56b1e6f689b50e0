// SPDX-License-Identifier: MIT
// Rows that go to and from the file without passing the library's filters.
#include <algorithm>
#include <bit>

#include <hdf5.h>

#include "datasets/base/error.h"
#include "datasets/hdf5/hdf5_file.h"

namespace trilat {
namespace {

std::vector<hsize_t> first_element(std::uint64_t row, std::size_t row_rank) {
  std::vector<hsize_t> offset(1 + row_rank, 0);
  offset[0] = row;
  return offset;
}

int filter_at(hid_t list, unsigned index) {
  unsigned flags = 0, config = 0;
  std::size_t values = 0;
  return H5Pget_filter2(list, index, &flags, &values, nullptr, 0, nullptr, &config);
}

std::optional<ChunkCompression> compression_of(hid_t list) {
  const int filters = H5Pget_nfilters(list);
  if (filters < 1 || filters > 2 ||
      filter_at(list, static_cast<unsigned>(filters - 1)) != H5Z_FILTER_FLETCHER32)
    return std::nullopt;
  if (filters == 1) return ChunkCompression::none;
  const int filter = filter_at(list, 0);
  if (filter == kBloscFilter) return ChunkCompression::blosc;
  if (filter == kDeflateFilter) return ChunkCompression::deflate;
  return std::nullopt;
}

}  // namespace

void H5Table::append_filtered_row(std::span<const std::byte> chunk) {
  const std::uint64_t row = rows();
  extend_to(row + 1);
  if (H5Dwrite_chunk(id_.id(), H5P_DEFAULT, 0, first_element(row, row_shape_.size()).data(), chunk.size(),
                     chunk.data()) < 0)
    throw OutputError(place_, "cannot be written");
}

std::optional<ChunkCompression> H5Table::row_compression() const {
  const H5Handle list(H5Dget_create_plist(id_.id()), [](std::int64_t id) { return int{H5Pclose(id)}; });
  if (list.id() < 0 || H5Pget_layout(list.id()) != H5D_CHUNKED) return std::nullopt;
  std::vector<hsize_t> chunk(1 + row_shape_.size(), 0);
  if (H5Pget_chunk(list.id(), static_cast<int>(chunk.size()), chunk.data()) !=
          static_cast<int>(chunk.size()) ||
      chunk[0] != 1 || !std::equal(row_shape_.begin(), row_shape_.end(), chunk.begin() + 1))
    return std::nullopt;
  return compression_of(list.id());
}

bool H5Table::has_filtered_row(std::uint64_t row) const {
  hsize_t bytes = 0;
  return H5Dget_chunk_storage_size(id_.id(), first_element(row, row_shape_.size()).data(), &bytes) < 0 ||
         bytes > 0;
}

// All chunks but the last can be kept: a writer at work, or killed, changes no other.
void H5Table::decode_chunk_at(std::uint64_t first_row) const {
  static_assert(std::endian::native == std::endian::little, "the file's numbers are little-endian");
  if (decoded_->first_row == first_row) return;
  decoded_->first_row.reset();
  decoded_->rows.assign(stored_.chunk_rows * row_elements_ * stored_.element_bytes, std::byte{0});
  const std::vector<hsize_t> offset = first_element(first_row, row_shape_.size());
  const bool last = first_row + stored_.chunk_rows >= rows();
  hsize_t bytes = 0;
  if (H5Dget_chunk_storage_size(id_.id(), offset.data(), &bytes) < 0)
    throw InputError(place_, "cannot be read (rows " + std::to_string(first_row) + " and following)");
  if (bytes > 0) {  // a chunk that was never written is all zeros
    std::uint32_t skipped = 0;
    std::vector<std::byte> chunk(bytes <= most_stored_bytes(decoded_->rows.size()) ? bytes : 0);
    if (chunk.empty() || H5Dread_chunk(id_.id(), H5P_DEFAULT, offset.data(), &skipped, chunk.data()) < 0 ||
        !decode_rows(std::move(chunk), stored_, skipped, !(last && torn_end_accepted_), decoded_->rows))
      throw InputError(place_, "cannot be read: the stored data are damaged (rows " +
                                   std::to_string(first_row) + " and following)");
  }
  if (!last) decoded_->first_row = first_row;
}

void H5Table::read_filtered(std::uint64_t first_row, std::span<std::byte> out) const {
  const std::uint64_t row_bytes = row_elements_ * stored_.element_bytes;
  const std::lock_guard lock(decoded_->mutex);
  for (std::uint64_t row = first_row; !out.empty();) {
    const std::uint64_t chunk_row = row / stored_.chunk_rows * stored_.chunk_rows;
    decode_chunk_at(chunk_row);
    const auto rows = std::span<const std::byte>(decoded_->rows).subspan((row - chunk_row) * row_bytes);
    const std::size_t count = std::min<std::size_t>(rows.size(), out.size());
    std::copy_n(rows.begin(), count, out.begin());
    out = out.subspan(count);
    row += count / row_bytes;
  }
}

std::vector<std::byte> H5Table::read_filtered_row(std::uint64_t row) const {
  const std::vector<hsize_t> offset = first_element(row, row_shape_.size());
  hsize_t bytes = 0;
  std::uint32_t mask = 0;
  const hsize_t most_bytes = most_stored_bytes(row_elements_ * stored_.element_bytes);
  if (H5Dget_chunk_storage_size(id_.id(), offset.data(), &bytes) < 0 || bytes == 0 || bytes > most_bytes)
    throw InputError(place_, "cannot be read: row " + std::to_string(row) + " is not there");
  std::vector<std::byte> chunk(bytes);
  if (H5Dread_chunk(id_.id(), H5P_DEFAULT, offset.data(), &mask, chunk.data()) < 0 || mask != 0)
    throw InputError(place_, "cannot be read: the stored data are damaged");
  return chunk;
}

}  // namespace trilat
