// SPDX-License-Identifier: MIT
// Rows that go to and from the file without passing the library's filters.
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

std::vector<std::byte> H5Table::read_filtered_row(std::uint64_t row) const {
  const std::vector<hsize_t> offset = first_element(row, row_shape_.size());
  hsize_t bytes = 0;
  const bool sound = H5Dget_chunk_storage_size(id_.id(), offset.data(), &bytes) >= 0 && bytes > 0 &&
                     bytes <= most_stored_bytes(stored_.chunk_bytes);
  std::vector<std::byte> chunk(sound ? bytes : 0);
  std::uint32_t skipped = 0;  // filters that the writer left out
  if (!sound || H5Dread_chunk(id_.id(), H5P_DEFAULT, offset.data(), &skipped, chunk.data()) < 0 ||
      skipped != 0)
    throw InputError(place_, "cannot be read: the stored data are damaged (row " + std::to_string(row) + ")");
  return chunk;
}

}  // namespace trilat
