// SPDX-License-Identifier: MIT
#include "pipeline/study/results_folder.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <thread>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/items.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

bool is_mount_point(const fs::path& folder) {
  struct statx s;
  return ::statx(AT_FDCWD, folder.c_str(), 0, STATX_BASIC_STATS, &s) == 0 &&
         (s.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0;
}

fs::path old_name(const fs::path& partial) { return partial.string() + ".old"; }

// All that this program left unfinished has a folder of items, if only an empty one.
void check_unfinished(const fs::path& partial) {
  const bool there = fs::exists(fs::symlink_status(partial));
  const bool ours = fs::is_directory(fs::symlink_status(partial)) &&
                    (fs::is_directory(partial / kItemsFolder) || fs::is_empty(partial));
  if (there && !ours)
    throw InputError(partial.string(),
                     "is nothing that this program left unfinished, and would be replaced; move it away");
}

}  // namespace

fs::path output_name(const fs::path& folder) {
  const fs::path name = folder.has_filename() ? folder : folder.parent_path();  // "results/"
  const bool is_dots = name.filename() == "." || name.filename() == "..";
  if (!is_dots && !fs::is_symlink(name)) return name;
  std::error_code error;
  fs::path there = fs::canonical(name, error);
  if (error)
    throw InputError(name.string(), "is a link that leads to no folder; make that, or remove the link");
  return there;
}

ResultsFolder::ResultsFolder(const fs::path& folder, bool keep_items)
    : output_(output_name(folder)), partial_(partial_name(output_)) {
  if (is_mount_point(output_))
    throw InputError(output_.string(),
                     "is a mount point, for which finished results cannot be exchanged; name a folder in it");
  if (partial_.has_parent_path()) make_folder(partial_.parent_path());
  check_unfinished(partial_);
  lock_.emplace(partial_);
  // from a process that was killed between two renames
  if (const fs::path old = old_name(partial_); !fs::exists(output_) && fs::is_directory(old))
    fs::rename(old, output_);
  make_folder(partial_ / kItemsFolder);
  for (const fs::directory_entry& entry : fs::directory_iterator(partial_))
    if (entry.path().filename() != kItemsFolder || !keep_items) fs::remove_all(entry.path());
  make_folder(partial_ / kItemsFolder);
}

// The older folder and the new one change names at once, where the file system can do that; else there is a
// moment in which the output has neither.
void ResultsFolder::exchange() const {
  const fs::path old = old_name(partial_);
  std::error_code error;
  fs::remove_all(old, error);
  bool moved = false;
  if (fs::exists(output_)) {
    const bool exchanged =
        ::renameat2(AT_FDCWD, partial_.c_str(), AT_FDCWD, output_.c_str(), RENAME_EXCHANGE) == 0;
    fs::rename(exchanged ? partial_ : output_, old, error);
    moved = !exchanged && !error;
    if (exchanged) {  // what cannot be removed now is removed under this name the next time
      fs::remove_all(error ? partial_ : old, error);
      return;
    }
  }
  if (!error) fs::rename(partial_, output_, error);
  if (std::error_code ignored; error && moved) fs::rename(old, output_, ignored);
  if (error) throw OutputError(output_.string(), "cannot be put in place: " + error.message());
  fs::remove_all(old, error);
}

void ResultsFolder::put_in_place(bool with_items) const {
  exchange();
  if (with_items) return;
  std::error_code error;
  fs::remove_all(output_ / kItemsFolder, error);
  if (error) throw OutputError((output_ / kItemsFolder).string(), "cannot be removed: " + error.message());
}

void on_threads(int threads, const std::function<void(int)>& work) {
  const int count = threads > 0 ? threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(count));
  tbb::task_arena arena(count);
  arena.execute([&] { work(count); });
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) {
      const auto colon = line.find(": ");
      return colon == std::string::npos ? "unknown" : line.substr(colon + 2);
    }
  return "unknown";
}

void write_run_record(const std::filesystem::path& folder, const Json& times, double wall_s, int threads) {
  Json json{{"format", "trilat.run"},
            {"version", 1},
            {"processor", processor_name()},
            {"processors", std::thread::hardware_concurrency()},
            {"threads", threads},
            {"compiler", __VERSION__},
            {"wall_s", wall_s}};
  json.update(times);
  write_file(folder / "run.json", json.dump(1) + "\n");
}

}  // namespace trilat
