// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "datasets/hdf5/chunk_codec.h"

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

// Owns one identifier of the HDF5 library.
class H5Handle {
 public:
  using Closer = int (*)(std::int64_t);
  H5Handle() = default;
  H5Handle(std::int64_t id, Closer closer) : id_(id), closer_(closer) {}
  H5Handle(H5Handle&& other) noexcept
      : id_(std::exchange(other.id_, -1)),
        closer_(std::exchange(other.closer_, nullptr)),
        failed_(std::move(other.failed_)) {}
  H5Handle& operator=(H5Handle&& other) noexcept;
  ~H5Handle();
  std::int64_t id() const { return id_; }
  // Negative when the library could not close it; once closed, nothing more happens.
  int close();
  // Sets `failed` when it is destroyed and cannot be closed: what the library still held is lost.
  void tell_failure_to(std::shared_ptr<bool> failed) { failed_ = std::move(failed); }

 private:
  std::int64_t id_ = -1;
  Closer closer_ = nullptr;
  std::shared_ptr<bool> failed_;
};

enum class H5Type { u8, u16, u32, u64, i64, f32, f64 };

template <class T>
constexpr H5Type h5_type_of() {
  if constexpr (std::is_same_v<T, std::uint8_t>) return H5Type::u8;
  if constexpr (std::is_same_v<T, std::uint16_t>) return H5Type::u16;
  if constexpr (std::is_same_v<T, std::uint32_t>) return H5Type::u32;
  if constexpr (std::is_same_v<T, std::uint64_t>) return H5Type::u64;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5Type::i64;
  if constexpr (std::is_same_v<T, float>) return H5Type::f32;
  if constexpr (std::is_same_v<T, double>) return H5Type::f64;
}

// How the rows of a table lie in the file.
struct H5Layout {
  std::size_t chunk_rows = 0;                             // 0: contiguous and of fixed size
  bool checksum = false;                                  // fletcher32 behind every chunk
  ChunkCompression compression = ChunkCompression::none;  // in front of it
  bool shuffle = false;  // the bytes of numbers, in front of that; not for append_filtered_row()
};

// Rows of one shape and type. Shape and storage are checked when a table is opened (check_stored_rows()), so
// that reads never exceed what the file really holds. All errors are InputError with the place
// `file.h5:/path`. Any number of threads may read a table; while one writes, no other may use it.
class H5Table {
 public:
  std::uint64_t rows() const;
  const std::string& place() const { return place_; }
  std::uint64_t row_elements() const { return row_elements_; }

  template <class T>
  void append(std::span<const T> values) {
    append_raw(values.data(), values.size(), h5_type_of<T>());
  }
  // Appends one row whose chunk (of one row) has already been through the filters.
  void append_filtered_row(std::span<const std::byte> chunk);
  // How such rows are compressed; nothing when chunks or filters are not those that encode_chunk() makes.
  std::optional<ChunkCompression> row_compression() const;
  // One row as it lies in the file, for decode_chunk(). The library decompresses under its one lock; this
  // leaves the work to the caller's thread. Only with row_compression().
  std::vector<std::byte> read_filtered_row(std::uint64_t row) const;
  // Whether the chunk of such a row is in the file; a killed writer may have announced more rows than it
  // wrote. What cannot be looked up counts as there: who reads it is told.
  bool has_filtered_row(std::uint64_t row) const;
  // For tables of a killed writer. What it last rewrote in place may be half old and half new: the rows are
  // there, and only the checksum behind them is not theirs. From now on such a last chunk is read.
  void ignore_last_checksum() { last_checksum_ignored_ = true; }
  template <class T>
  void write(std::uint64_t first_row, std::span<const T> values) {
    transfer(first_row, const_cast<T*>(values.data()), values.size(), h5_type_of<T>(), true);
  }
  template <class T>
  void read(std::uint64_t first_row, std::span<T> values) const {
    transfer(first_row, values.data(), values.size(), h5_type_of<T>(), false);
  }
  // Bytes that the rows take in the file, filters applied.
  std::uint64_t stored_bytes() const;

 private:
  friend class H5Node;
  void append_raw(const void* data, std::size_t elements, H5Type type);
  void transfer(std::uint64_t first_row, void* data, std::size_t elements, H5Type type, bool write) const;
  // False when the library says no. `transfer`: its properties.
  bool move_rows(std::uint64_t first_row, void* data, std::size_t elements, H5Type type, bool write,
                 std::int64_t transfer) const;
  void extend_to(std::uint64_t rows);

  H5Handle id_;
  std::string place_;
  std::vector<std::uint64_t> row_shape_;
  std::uint64_t row_elements_ = 1;
  StoredRows stored_;  // of a table that was opened
  bool last_checksum_ignored_ = false;
};

// A group, or the root of a file.
class H5Node {
 public:
  H5Node() = default;
  const std::string& place() const { return place_; }

  H5Node create_group(const std::string& name);
  H5Node group(const std::string& name) const;
  bool has(const std::string& name) const;
  // Names of the children, sorted; refuses more than `limit`.
  std::vector<std::string> children(std::size_t limit) const;

  void set_text(const std::string& name, const std::string& text);
  void set_integer(const std::string& name, std::int64_t value);
  void set_number(const std::string& name, double value);
  void set_texts(const std::string& name, const std::vector<std::string>& texts);
  std::string text(const std::string& name) const;
  std::int64_t integer(const std::string& name) const;
  double number(const std::string& name) const;
  std::vector<std::string> texts(const std::string& name) const;
  bool has_attribute(const std::string& name) const;

  // An empty table that grows by appending (layout.chunk_rows > 0), or one of `rows` rows filled with zeros.
  H5Table create_table(const std::string& name, H5Type type, const std::vector<std::uint64_t>& row_shape,
                       const H5Layout& layout, std::uint64_t rows = 0);
  // Opens a table and refuses any other element kind (integer or floating) or row shape.
  H5Table table(const std::string& name, H5Type type, const std::vector<std::uint64_t>& row_shape) const;

 protected:
  std::string place_of(const std::string& name) const;
  H5Handle id_;
  std::string place_;
  std::shared_ptr<bool> rows_lost_;  // of the file: a table that was written could not be closed
};

// A file opened for one purpose. Files are written in the latest format.
class H5File : public H5Node {
 public:
  static H5File create(const std::filesystem::path& path);
  // For reading. A file whose writer is at work, or was killed, is opened as an SWMR reader: what was flushed
  // is there.
  static H5File open(const std::filesystem::path& path);

  void flush();
  // Flushes and closes; OutputError when not all reached the file. Its tables and groups must be gone.
  void close();
  // After a failed write: nothing more is written, so that what was flushed stays as it is.
  void detach_after_write_error() noexcept;
  // True when the file was opened while its writer had not closed it.
  bool unfinished() const { return unfinished_; }

 private:
  bool unfinished_ = false;
};

}  // namespace trilat
