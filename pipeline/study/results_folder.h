// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace trilat {

using Kept = std::vector<std::string>;  // names of files and folders

// The name under which an output is put in place: what a link leads to, without a slash at the end.
std::filesystem::path output_name(const std::filesystem::path& folder);

// A results folder, or a part of one, that is filled beside its name and put in place at the end. What
// stands under the name is replaced, whatever it is: the verb has asked whether it may be. What is not put
// in place stays as `output`.partial.
class ResultsFolder {
 public:
  // Of a folder that was left unfinished, `kept` stays, all else is removed. InputError when another
  // process is filling it.
  explicit ResultsFolder(const std::filesystem::path& folder, const Kept& kept = {});
  ~ResultsFolder();
  ResultsFolder(const ResultsFolder&) = delete;
  ResultsFolder& operator=(const ResultsFolder&) = delete;

  const std::filesystem::path& partial() const { return partial_; }
  const std::filesystem::path& output() const { return output_; }
  // `unfinished`: what only an unfinished output needs; it is removed afterwards, so that whatever happens
  // the work goes on from it.
  void put_in_place(const Kept& unfinished = {}) const;

 private:
  void exchange() const;

  std::filesystem::path output_, partial_;
  int lock_ = -1;
};

// Calls work(threads) on so many threads; 0: as many as there are processors.
void on_threads(int threads, const std::function<void(int)>& work);

}  // namespace trilat
