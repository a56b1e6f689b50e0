// SPDX-License-Identifier: MIT
#include "pipeline/results_folder.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

void check_output(const fs::path& output) {
  if (!fs::exists(output)) return;
  const bool empty = fs::is_directory(output) && fs::is_empty(output);
  const bool results = fs::exists(output / "summary.json") && fs::exists(output / "manifest.json") &&
                       fs::exists(output / "run.json");
  const bool part = fs::exists(output / "part.json");
  if (!empty && !results && !part)
    throw InputError(output.string(), "exists and is not a results folder; choose another name or remove it");
}

// Held as long as the process fills the folder. It lies beside it, so that it is never part of an output.
int lock_folder(const fs::path& partial) {
  const fs::path name = partial.string() + ".lock";
  for (;;) {
    const int file = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0) throw OutputError(name.string(), std::string("cannot be created: ") + std::strerror(errno));
    if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
      const int reason = errno;
      ::close(file);
      if (reason != EWOULDBLOCK)
        throw OutputError(name.string(), std::string("cannot be locked: ") + std::strerror(reason));
      throw InputError(partial.string(),
                       "is being written by another process; wait for it or take another name");
    }
    // the one before removes the file when it ends: then this one is nobody's
    struct stat mine, there;
    if (::fstat(file, &mine) == 0 && ::stat(name.c_str(), &there) == 0 && mine.st_ino == there.st_ino)
      return file;
    ::close(file);
  }
}

}  // namespace

ResultsFolder::ResultsFolder(const fs::path& folder, const Kept& kept)
    : output_(folder.has_filename() ? folder : folder.parent_path()),  // "results/"
      partial_(partial_name(output_)) {
  check_output(output_);
  if (partial_.has_parent_path()) make_folder(partial_.parent_path());
  lock_ = lock_folder(partial_);
  if (fs::is_directory(partial_)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(partial_))
      if (std::find(kept.begin(), kept.end(), entry.path().filename().string()) == kept.end())
        fs::remove_all(entry.path());
  } else {
    fs::remove(partial_);
  }
  make_folder(partial_);
}

ResultsFolder::~ResultsFolder() {
  ::unlink((partial_.string() + ".lock").c_str());
  ::close(lock_);
}

// The older folder and the new one change names at once, where the file system can do that; else there is a
// moment in which the output has neither.
void ResultsFolder::put_in_place() const {
  const fs::path old = partial_.string() + ".old";
  std::error_code error;
  fs::remove_all(old, error);
  bool moved = false;
  if (fs::exists(output_)) {
    if (::renameat2(AT_FDCWD, partial_.c_str(), AT_FDCWD, output_.c_str(), RENAME_EXCHANGE) == 0) {
      fs::remove_all(partial_, error);
      return;
    }
    fs::rename(output_, old, error);
    moved = !error;
  }
  if (!error) fs::rename(partial_, output_, error);
  if (std::error_code ignored; error && moved) fs::rename(old, output_, ignored);
  if (error) throw OutputError(output_.string(), "cannot be put in place: " + error.message());
  fs::remove_all(old, error);
}

void ResultsFolder::discard() const {
  std::error_code ignored;
  fs::remove_all(partial_, ignored);
}

void on_threads(int threads, const std::function<void(int)>& work) {
  const int count = threads > 0 ? threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(count));
  tbb::task_arena arena(count);
  arena.execute([&] { work(count); });
}

}  // namespace trilat
