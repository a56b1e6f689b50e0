// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include <hdf5.h>

#include "datasets/base/error.h"
#include "datasets/hdf5/chunk_codec.h"
#include "datasets/hdf5/hdf5_file.h"

namespace trilat {
namespace {

constexpr std::uint64_t kMaxChunkBytes = std::uint64_t{16} << 20;
constexpr std::uint64_t kMaxChunks = std::uint64_t{1} << 26;
// A killed writer may have announced rows that still were in the library's cache of 1 MB.
constexpr std::uint64_t kAnnouncedBytes = std::uint64_t{4} << 20;

int close_properties(std::int64_t id) { return H5Pclose(id); }
int close_extent(std::int64_t id) { return H5Sclose(id); }
int close_owner(std::int64_t id) { return H5Fclose(id); }

struct Shape {
  std::uint64_t rows = 0;
  std::uint64_t row_bytes = 0;
};

std::uint64_t file_bytes(std::int64_t dataset) {
  const H5Handle file(H5Iget_file_id(dataset), close_owner);
  hsize_t bytes = 0;
  return file.id() >= 0 && H5Fget_filesize(file.id(), &bytes) >= 0 ? bytes : 0;
}

Shape shape_of(std::int64_t dataset, const std::string& place, const std::vector<std::uint64_t>& row_shape,
               std::size_t element_bytes) {
  const H5Handle space(H5Dget_space(dataset), close_extent);
  hsize_t dims[H5S_MAX_RANK] = {};
  if (space.id() < 0 || H5Sget_simple_extent_dims(space.id(), dims, nullptr) < 1)
    throw InputError(place, "has no rows");
  Shape shape{dims[0], element_bytes};
  for (const std::uint64_t extent : row_shape) shape.row_bytes *= extent;
  return shape;
}

[[noreturn]] void refuse_claim(const std::string& place, std::uint64_t rows) {
  throw InputError(place, "claims " + std::to_string(rows) + " rows, more than the file holds");
}

// Blosc's filter is told how many bytes a chunk holds, and the library believes it.
std::vector<int> filters_of(hid_t list, std::uint64_t chunk_bytes, const std::string& place) {
  std::vector<int> filters;
  for (int i = 0; i < H5Pget_nfilters(list); ++i) {
    unsigned flags = 0, config = 0;
    std::array<unsigned, kBloscValues> values{};
    std::size_t count = values.size();
    filters.push_back(
        H5Pget_filter2(list, static_cast<unsigned>(i), &flags, &count, values.data(), 0, nullptr, &config));
    if (filters.back() == kBloscFilter &&
        (count <= kBloscChunkBytes || values[kBloscChunkBytes] != chunk_bytes))
      throw InputError(place, "cannot be read: the stored data are damaged (Blosc is told of other chunks)");
  }
  return filters;
}

// Each at most once, in the order that writers use: shuffle, a compression, checksum.
bool can_be_undone(const std::vector<int>& filters) {
  const auto turn = [](int filter) {
    return filter == H5Z_FILTER_SHUFFLE                         ? 1
           : filter == kDeflateFilter || filter == kBloscFilter ? 2
           : filter == H5Z_FILTER_FLETCHER32                    ? 3
                                                                : 0;
  };
  int last = 0;
  for (const int filter : filters) {
    if (turn(filter) <= last) return false;
    last = turn(filter);
  }
  return true;
}

void check_chunks(std::int64_t dataset, hid_t list, const std::string& place,
                  const std::vector<std::uint64_t>& row_shape, const Shape& shape, StoredRows& stored) {
  std::vector<hsize_t> chunk(1 + row_shape.size(), 0);
  const int rank = static_cast<int>(chunk.size());
  if (H5Pget_chunk(list, rank, chunk.data()) != rank || chunk[0] == 0 ||
      !std::equal(row_shape.begin(), row_shape.end(), chunk.begin() + 1))
    throw InputError(place, "is cut into chunks that do not hold whole rows");
  if (shape.row_bytes == 0 || chunk[0] > kMaxChunkBytes / shape.row_bytes)
    throw InputError(place, "has chunks of more than 16 MB, which this format does not have");
  stored.chunk_rows = chunk[0];
  stored.chunk_bytes = chunk[0] * shape.row_bytes;
  stored.filters = filters_of(list, stored.chunk_bytes, place);
  if (!can_be_undone(stored.filters))
    throw InputError(place,
                     "uses filters that are not read; `h5repack -f NONE` makes a copy without filters");
  const std::uint64_t most_rows = kMaxChunks * chunk[0];
  hsize_t chunks = 0;
  const H5Handle space(H5Dget_space(dataset), close_extent);
  if (shape.rows > most_rows) refuse_claim(place, shape.rows);
  if (H5Dget_num_chunks(dataset, space.id(), &chunks) < 0 || chunks > kMaxChunks)
    throw InputError(place, "cannot be read: the list of its chunks is damaged");
  if (stored.filters.empty() && chunks > file_bytes(dataset) / stored.chunk_bytes)
    refuse_claim(place, shape.rows);
  const std::uint64_t announced_rows = std::max<std::uint64_t>(chunk[0], kAnnouncedBytes / shape.row_bytes);
  if (shape.rows > chunks * chunk[0] + announced_rows) refuse_claim(place, shape.rows);
}

}  // namespace

StoredRows check_stored_rows(std::int64_t dataset, const std::string& place,
                             const std::vector<std::uint64_t>& row_shape, std::size_t element_bytes) {
  const H5Handle list(H5Dget_create_plist(dataset), close_properties);
  if (list.id() < 0) throw InputError(place, "does not say how it is stored");
  const Shape shape = shape_of(dataset, place, row_shape, element_bytes);
  StoredRows stored;
  const H5D_layout_t layout = H5Pget_layout(list.id());
  if (layout == H5D_VIRTUAL || H5Pget_external_count(list.id()) != 0)
    throw InputError(place,
                     "takes its rows from another file, which is not read; `h5repack` cannot mend it, "
                     "whoever made it can");
  if (layout == H5D_CHUNKED) {
    check_chunks(dataset, list.id(), place, row_shape, shape, stored);
    return stored;
  }
  const std::uint64_t bytes = std::min<std::uint64_t>(H5Dget_storage_size(dataset), file_bytes(dataset));
  if (shape.row_bytes == 0 || shape.rows > bytes / shape.row_bytes) refuse_claim(place, shape.rows);
  return stored;
}

std::uint64_t most_stored_bytes(std::uint64_t raw_bytes) { return raw_bytes + raw_bytes / 256 + 1024; }

}  // namespace trilat
