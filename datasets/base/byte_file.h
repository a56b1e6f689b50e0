// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>

namespace trilat {

// A binary file that is read at any place.
class ByteFile {
 public:
  // InputError when the file cannot be opened.
  explicit ByteFile(const std::filesystem::path& path);
  ~ByteFile();
  ByteFile(const ByteFile&) = delete;
  ByteFile& operator=(const ByteFile&) = delete;

  std::uint64_t size() const { return size_; }
  // Fills `bytes` from `offset`; false when the file is shorter. InputError when the disk fails.
  bool read(std::uint64_t offset, std::span<std::byte> bytes) const;
  // "a.xef (byte 1234)".
  std::string place(std::uint64_t offset) const;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int file_ = -1;
  std::uint64_t size_ = 0;
};

// A number at a place of little-endian bytes; the caller knows that they are there.
template <class T>
T value_at(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.subspan(offset, sizeof(T)).data(), sizeof(T));
  return value;
}

}  // namespace trilat
