// SPDX-License-Identifier: MIT
#include "pipeline/results_folder.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

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
  if (!empty && !results)
    throw InputError(output.string(), "exists and is not a results folder; choose another name or remove it");
}

}  // namespace

ResultsFolder::ResultsFolder(const fs::path& folder)
    : output_(folder.has_filename() ? folder : folder.parent_path()),  // "results/"
      partial_(partial_name(output_)) {
  check_output(output_);
  fs::remove_all(partial_);
  make_folder(partial_);
}

void ResultsFolder::put_in_place() const {
  const fs::path old = partial_.string() + ".old";
  std::error_code error;
  fs::remove_all(old, error);
  if (fs::exists(output_)) fs::rename(output_, old, error);
  if (!error) fs::rename(partial_, output_, error);
  if (error) throw InputError(output_.string(), "cannot be put in place: " + error.message());
  fs::remove_all(old, error);
}

void on_threads(int threads, const std::function<void(int)>& work) {
  const int count = threads > 0 ? threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(count));
  tbb::task_arena arena(count);
  arena.execute([&] { work(count); });
}

}  // namespace trilat
