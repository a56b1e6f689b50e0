// SPDX-License-Identifier: MIT
#include "recorders/capture_sync.h"

#include <fcntl.h>
#include <unistd.h>

namespace trilat {

CaptureSync::CaptureSync(const std::filesystem::path& file, std::chrono::milliseconds period)
    : file_(::open(file.c_str(), O_RDONLY | O_CLOEXEC)), thread_([this, period] {
        std::unique_lock lock(mutex_);
        while (!ended_changed_.wait_for(lock, period, [&] { return ended_; })) {
          lock.unlock();
          if (file_ >= 0) (void)::fdatasync(file_);  // a disk that fails tells the writer, too
          lock.lock();
        }
      }) {}

CaptureSync::~CaptureSync() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  ended_changed_.notify_all();
  thread_.join();
  if (file_ >= 0) ::close(file_);
}

}  // namespace trilat
