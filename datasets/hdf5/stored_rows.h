// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace trilat {

// How the rows of an opened dataset lie in its file.
struct StoredRows {
  std::uint64_t chunk_rows = 0;  // 0: not in chunks
  std::size_t element_bytes = 0;
  std::vector<int> filters;  // HDF5's numbers, in the order in which the writer applied them
};

// Looks before anything is read. InputError at `place` unless the rows are whole and in this very file: not
// in another one, not more than the file has room for, in chunks of whole rows, filtered as decode_rows()
// undoes.
StoredRows check_stored_rows(std::int64_t dataset, const std::string& place,
                             const std::vector<std::uint64_t>& row_shape, std::size_t element_bytes);

// A chunk can be stored in no more bytes than this, whatever its filters.
std::uint64_t most_stored_bytes(std::uint64_t raw_bytes);

// Undoes the filters of one chunk into exactly raw.size() bytes and never more. Bit i of `skipped`: the
// writer left filter i out. False when the chunk is damaged or of another size. The library's own filters
// would inflate without limit and believe sizes that the chunk states.
bool decode_rows(std::vector<std::byte> chunk, const StoredRows& stored, std::uint32_t skipped,
                 bool check_sum, std::span<std::byte> raw);

}  // namespace trilat
