// SPDX-License-Identifier: MIT
#include "datasets/session/append_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#ifdef _WIN32
#include <io.h>
#include <share.h>
#include <windows.h>
#include <winioctl.h>
#else
#include <sys/file.h>
#include <unistd.h>
#endif

#include "datasets/base/error.h"

namespace trilat {
namespace {

// The calls that differ between systems. On Windows the open itself locks: who else wants to write is
// refused.
#ifdef _WIN32
int open_locked(const std::filesystem::path& path, bool create) {
  int file = -1;
  const int mode = _O_WRONLY | _O_BINARY | _O_NOINHERIT | (create ? _O_CREAT | _O_EXCL : 0);
  errno = _wsopen_s(&file, path.c_str(), mode, _SH_DENYWR, _S_IREAD | _S_IWRITE);
  return file;
}
bool truncate_to(int file, std::uint64_t bytes) { return _chsize_s(file, static_cast<__int64>(bytes)) == 0; }
bool seek_to_end(int file) { return _lseeki64(file, 0, SEEK_END) >= 0; }
bool sync_now(int file) { return _commit(file) == 0; }
int write_some(int file, const void* data, std::size_t size) {
  return _write(file, data, static_cast<unsigned>(std::min<std::size_t>(size, 1u << 20)));
}
void close_file(int file) { _close(file); }
void release_to(int file, std::uint64_t bytes) {
  const auto handle = reinterpret_cast<HANDLE>(_get_osfhandle(file));
  DWORD unused = 0;
  FILE_ZERO_DATA_INFORMATION range{};
  range.BeyondFinalZero.QuadPart = static_cast<LONGLONG>(bytes);
  ::DeviceIoControl(handle, FSCTL_SET_SPARSE, nullptr, 0, nullptr, 0, &unused, nullptr);
  ::DeviceIoControl(handle, FSCTL_SET_ZERO_DATA, &range, sizeof range, nullptr, 0, &unused, nullptr);
}
#else
int open_locked(const std::filesystem::path& path, bool create) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | (create ? O_CREAT | O_EXCL : 0), 0600);
  if (file >= 0 && ::flock(file, LOCK_EX | LOCK_NB) != 0) {
    ::close(file);
    errno = EACCES;
    return -1;
  }
  return file;
}
bool truncate_to(int file, std::uint64_t bytes) { return ::ftruncate(file, static_cast<off_t>(bytes)) == 0; }
bool seek_to_end(int file) { return ::lseek(file, 0, SEEK_END) >= 0; }
bool sync_now(int file) { return ::fdatasync(file) == 0; }
ssize_t write_some(int file, const void* data, std::size_t size) { return ::write(file, data, size); }
void close_file(int file) { ::close(file); }
void release_to(int file, std::uint64_t bytes) {
  (void)::fallocate(file, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes));
}
#endif

[[noreturn]] void refuse(const std::filesystem::path& path, const char* what) {
  throw OutputError(path.string(), std::string("cannot be ") + what + ": " + std::strerror(errno));
}

}  // namespace

AppendFile::AppendFile(std::filesystem::path path, Open how, std::uint64_t keep_bytes)
    : path_(std::move(path)) {
  file_ = open_locked(path_, how == Open::create);
  if (file_ < 0 && errno == EEXIST) throw InputError(path_.string(), "exists; take another name");
  if (file_ < 0 && errno == EACCES && std::filesystem::exists(path_) && is_being_written(path_))
    throw InputError(path_.string(), "is being written by another process");
  if (file_ < 0) refuse(path_, how == Open::create ? "created" : "opened");
  if (how == Open::extend && (!truncate_to(file_, keep_bytes) || !seek_to_end(file_))) {
    close_file(file_);
    refuse(path_, "cut to its whole records");
  }
}

AppendFile::~AppendFile() { close_file(file_); }

void AppendFile::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto written = write_some(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) refuse(path_, "written");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void AppendFile::sync() {
  if (!sync_now(file_)) refuse(path_, "put on the disk");
}

void AppendFile::release(std::uint64_t bytes) noexcept {
  if (bytes > 0) release_to(file_, bytes);
}

bool is_being_written(const std::filesystem::path& path) {
#ifdef _WIN32
  int file = -1;
  const bool shared =
      _wsopen_s(&file, path.c_str(), _O_RDONLY | _O_BINARY | _O_NOINHERIT, _SH_DENYWR, 0) != 0;
  if (file >= 0) close_file(file);
  return shared && std::filesystem::exists(path);
#else
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool locked = ::flock(file, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(file);
  return locked;
#endif
}

}  // namespace trilat
