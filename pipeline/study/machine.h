// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "datasets/base/json.h"

namespace trilat {

// Calls work(threads) on so many threads; 0: as many as there are processors.
void on_threads(int threads, const std::function<void(int)>& work);

// run.json: what may differ between equal runs: the machine, the number of threads, the times; `more`: what
// else it says. What the results are marked by stays in it.
void write_run_record(const std::filesystem::path& folder, const std::filesystem::path& results,
                      const Json& more, double wall_s, int threads);

// Name of the processor as this machine calls it, or "unknown".
std::string processor_name();

}  // namespace trilat
