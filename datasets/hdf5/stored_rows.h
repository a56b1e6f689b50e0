// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace trilat {

// How the rows of an opened dataset lie in its file.
struct StoredRows {
  std::uint64_t chunk_rows = 0;  // 0: not in chunks
  std::uint64_t chunk_bytes = 0;
  std::vector<int> filters;  // HDF5's numbers, in the order in which the writer applied them
};

// Looks before anything is read. InputError at `place` unless the rows are whole and in this very file: not
// in another one, not more than the file has room for, in chunks of whole rows of 16 MB at most, by filters
// that are read.
StoredRows check_stored_rows(std::int64_t dataset, const std::string& place,
                             const std::vector<std::uint64_t>& row_shape, std::size_t element_bytes);

// A chunk can be stored in no more bytes than this, whatever its filters.
std::uint64_t most_stored_bytes(std::uint64_t raw_bytes);

}  // namespace trilat
