// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"

namespace trilat {

// The name under which an output is put in place: what a link leads to, without a slash at the end.
std::filesystem::path output_name(const std::filesystem::path& folder);

// A results folder, or a part of one, that is filled beside its name and put in place at the end. What stands
// under the name is replaced, whatever it is: the verb has asked whether it may be. What is not put in place
// stays as `output`.partial.
class ResultsFolder {
 public:
  // Of a folder that was left unfinished the items stay, if asked, all else is removed. InputError when
  // another process is filling it, and when what stands there was not left by this program.
  explicit ResultsFolder(const std::filesystem::path& folder, bool keep_items = false);

  const std::filesystem::path& partial() const { return partial_; }
  const std::filesystem::path& output() const { return output_; }
  // Items that only the unfinished output needs are removed afterwards, so that whatever happens the work
  // goes on from them.
  void put_in_place(bool with_items = false) const;

 private:
  void exchange() const;

  std::filesystem::path output_, partial_;
  std::optional<FolderLock> lock_;
};

// Calls work(threads) on so many threads; 0: as many as there are processors.
void on_threads(int threads, const std::function<void(int)>& work);

// run.json: what may differ between equal runs: the machine, the number of threads, the times; `more`: what
// else it says.
void write_run_record(const std::filesystem::path& folder, const Json& more, double wall_s, int threads);

// As this machine calls it, or "unknown".
std::string processor_name();

}  // namespace trilat
