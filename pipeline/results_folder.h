// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>

namespace trilat {

// A results folder that is filled beside its name and put in place at the end; an older results folder of
// that name is replaced, any other folder is refused. What is not put in place stays as `output`.partial.
class ResultsFolder {
 public:
  explicit ResultsFolder(const std::filesystem::path& folder);
  const std::filesystem::path& partial() const { return partial_; }
  void put_in_place() const;

 private:
  std::filesystem::path output_, partial_;
};

// Calls work(threads) on so many threads; 0: as many as there are processors.
void on_threads(int threads, const std::function<void(int)>& work);

}  // namespace trilat
