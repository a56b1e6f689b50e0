// SPDX-License-Identifier: MIT
#include "datasets/base/byte_file.h"

#include <bit>
#include <cerrno>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "datasets/base/error.h"

namespace trilat {

static_assert(std::endian::native == std::endian::little, "value_at() copies bytes as they lie");

ByteFile::ByteFile(const std::filesystem::path& path) : path_(path.string()) {
  file_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) throw InputError(path_, std::string("cannot be opened: ") + std::strerror(errno));
  struct stat state {};
  if (::fstat(file_, &state) != 0 || !S_ISREG(state.st_mode)) {
    ::close(file_);
    throw InputError(path_, "is no file");
  }
  size_ = static_cast<std::uint64_t>(state.st_size);
}

ByteFile::~ByteFile() { ::close(file_); }

std::string ByteFile::place(std::uint64_t offset) const {
  return path_ + " (byte " + std::to_string(offset) + ")";
}

bool ByteFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  if (offset > size_ || bytes.size() > size_ - offset) return false;
  while (!bytes.empty()) {
    const ssize_t count = ::pread(file_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw InputError(path_, std::string("cannot be read: ") + std::strerror(errno));
    if (count == 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
  return true;
}

}  // namespace trilat
