// SPDX-License-Identifier: MIT
#include "pipeline/study/machine.h"

#include <fstream>
#include <latch>
#include <system_error>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/json.h"

namespace trilat {

namespace {

// TBB ends the program where the system does not start a thread that it wants: they are tried first.
void check_threads(int count) {
  std::latch all_started(1);
  std::vector<std::jthread> threads;
  try {
    for (int k = 1; k < count; ++k) threads.emplace_back([&] { all_started.wait(); });
  } catch (const std::system_error&) {
    all_started.count_down();
    throw InputError("--threads",
                     std::to_string(count) + " threads are more than the system starts; give fewer");
  }
  all_started.count_down();
}

}  // namespace

void on_threads(int threads, const std::function<void(int)>& work) {
  const int count = threads > 0 ? threads : tbb::info::default_concurrency();
  check_threads(count);
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

void write_run_record(const std::filesystem::path& folder, const std::filesystem::path& results,
                      const Json& times, double wall_s, int threads) {
  Json json{{"format", "trilat.run"}, {"version", 1}};
  if (std::filesystem::exists(results / "run.json")) {
    const Json before = read_json(results / "run.json");
    for (const char* key : {"verb", "names", "campaign"})
      if (before.contains(key)) json[key] = before[key];
  }
  json.update(Json{{"processor", processor_name()},
                   {"processors", std::thread::hardware_concurrency()},
                   {"threads", threads},
                   {"compiler", __VERSION__},
                   {"wall_s", wall_s}});
  json.update(times);
  write_file(folder / "run.json", json.dump(1) + "\n");
}

}  // namespace trilat
