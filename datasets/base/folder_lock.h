// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace trilat {

// Held by the process that fills a folder; of a process that ends anyhow the system takes it away. The lock
// is `folder`.lock: beside the folder, so that it is never part of an output.
class FolderLock {
 public:
  // InputError when another process has it; OutputError when there can be none.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path name_;
  int file_ = -1;
};

}  // namespace trilat
