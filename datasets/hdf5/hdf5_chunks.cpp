// SPDX-License-Identifier: MIT
// Rows that go to and from the file without passing the library's filters.
#include <algorithm>

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

}  // namespace

void H5Table::append_filtered_row(std::span<const std::byte> chunk) {
  const std::uint64_t row = rows();
  extend_to(row + 1);
  if (H5Dwrite_chunk(id_.id(), H5P_DEFAULT, 0, first_element(row, row_shape_.size()).data(), chunk.size(),
                     chunk.data()) < 0)
    throw OutputError(place_, "cannot be written");
}

std::optional<ChunkCompression> H5Table::row_compression() const {
  const std::vector<int>& filters = stored_.filters;
  if (stored_.chunk_rows != 1 || filters.empty() || filters.size() > 2 ||
      filters.back() != H5Z_FILTER_FLETCHER32)
    return std::nullopt;
  if (filters.size() == 1) return ChunkCompression::none;
  if (filters[0] == kBloscFilter) return ChunkCompression::blosc;
  if (filters[0] == kDeflateFilter) return ChunkCompression::deflate;
  return std::nullopt;
}

bool H5Table::has_filtered_row(std::uint64_t row) const {
  hsize_t bytes = 0;
  return H5Dget_chunk_storage_size(id_.id(), first_element(row, row_shape_.size()).data(), &bytes) < 0 ||
         bytes > 0;
}

std::vector<std::byte> H5Table::stored_chunk(std::uint64_t first_row, std::uint32_t& skipped) const {
  const std::vector<hsize_t> offset = first_element(first_row, row_shape_.size());
  const hsize_t most = most_stored_bytes(stored_.chunk_rows * row_elements_ * stored_.element_bytes);
  hsize_t bytes = 0;
  const bool sound = H5Dget_chunk_storage_size(id_.id(), offset.data(), &bytes) >= 0 && bytes <= most;
  std::vector<std::byte> chunk(sound ? bytes : 0);
  if (!sound ||
      (bytes > 0 && H5Dread_chunk(id_.id(), H5P_DEFAULT, offset.data(), &skipped, chunk.data()) < 0))
    refuse_damaged(first_row);
  return chunk;
}

void H5Table::refuse_damaged(std::uint64_t first_row) const {
  throw InputError(place_, "cannot be read: the stored data are damaged (rows " + std::to_string(first_row) +
                               " and following)");
}

// All chunks but the last can be kept: a writer at work, or killed, changes no other.
void H5Table::decode_chunk_at(std::uint64_t first_row) const {
  if (decoded_->first_row == first_row) return;
  decoded_->first_row.reset();
  decoded_->rows.assign(stored_.chunk_rows * row_elements_ * stored_.element_bytes, std::byte{0});
  const bool last = first_row + stored_.chunk_rows >= rows();
  std::uint32_t skipped = 0;
  std::vector<std::byte> chunk = stored_chunk(first_row, skipped);
  if (!chunk.empty() &&  // a chunk that was never written is all zeros
      !decode_rows(std::move(chunk), stored_, skipped, !(last && torn_end_accepted_), decoded_->rows))
    refuse_damaged(first_row);
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
  std::uint32_t skipped = 0;
  std::vector<std::byte> chunk = stored_chunk(row, skipped);
  if (chunk.empty() || skipped != 0) refuse_damaged(row);
  return chunk;
}

}  // namespace trilat
