// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace trilat {

// A file that only grows, locked against other writers while it is open. Errors are OutputError with the
// path.
class AppendFile {
 public:
  enum class Open { create, extend };
  // create: InputError when the file exists. extend: of an existing file the bytes behind `keep_bytes` are
  // cut off; InputError when another process writes it.
  AppendFile(std::filesystem::path path, Open how, std::uint64_t keep_bytes = 0);
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  void append(std::span<const std::byte> bytes);
  void sync();  // waits until all is on the disk
  // Gives the room of the first `bytes` back to the disk, where the file system can; they read as zeros then.
  void release(std::uint64_t bytes) noexcept;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int file_ = -1;
};

// Whether an AppendFile of this or another process is open on the file.
bool is_being_written(const std::filesystem::path& path);

}  // namespace trilat
