// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>

#include <fcntl.h>
#include <unistd.h>

namespace trilat {

// Bytes under a name of the file system, in memory where there is /dev/shm. A file without a name of its own
// (memfd) would not do: HDF5 looks for the real path of what it opens, and there is none.
class MemoryFile {
 public:
  explicit MemoryFile(std::span<const std::uint8_t> bytes) {
    static int count = 0;
    const std::filesystem::path shared = "/dev/shm";
    path_ = (std::filesystem::exists(shared) ? shared : std::filesystem::temp_directory_path()) /
            ("trilat_fuzz_" + std::to_string(::getpid()) + "_" + std::to_string(++count));
    const int file = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (file < 0 || ::write(file, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
      std::abort();
    ::close(file);
  }
  ~MemoryFile() { ::unlink(path_.c_str()); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace trilat
