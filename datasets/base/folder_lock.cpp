// SPDX-License-Identifier: MIT
#include "datasets/base/folder_lock.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "datasets/base/error.h"

namespace trilat {

FolderLock::FolderLock(const std::filesystem::path& folder) : name_(folder.string() + ".lock") {
  for (;;) {
    file_ = ::open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file_ < 0)
      throw OutputError(name_.string(), std::string("cannot be created: ") + std::strerror(errno));
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
      const int reason = errno;
      ::close(file_);
      if (reason != EWOULDBLOCK)
        throw OutputError(name_.string(), std::string("cannot be locked: ") + std::strerror(reason));
      throw InputError(folder.string(),
                       "is being written by another process; wait for it or take another name");
    }
    // the one before removes the file when it ends: then this one is nobody's
    struct stat mine, there;
    if (::fstat(file_, &mine) == 0 && ::stat(name_.c_str(), &there) == 0 && mine.st_ino == there.st_ino)
      return;
    ::close(file_);
  }
}

FolderLock::~FolderLock() {
  ::unlink(name_.c_str());
  ::close(file_);
}

}  // namespace trilat
