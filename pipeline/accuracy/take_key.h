// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_result.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/run_control.h"

namespace trilat {

// The files that a take is made of, by what they are.
struct TakeFile {
  std::string role;
  std::filesystem::path path;
};
std::vector<TakeFile> files_of(const Take& take);

// Ask before the take is planned, and check() after it was evaluated.
WatchedFiles watched_files(const Take& take);

// The files of a take with their hashes. Interrupted when asked to stop.
std::vector<TakeInput> inputs_of(const Take& take, HashCache& hashes,
                                 const std::function<bool()>& stop_requested);

// The key of a take's work item: equal keys, equal samples and equal result. What only the summary needs
// (names, alignments, intervals) is not in it, so that changing it costs no take.
std::string key_of_take(const Plan& plan, std::size_t take, std::span<const TakeInput> inputs,
                        bool cross_check);

}  // namespace trilat
