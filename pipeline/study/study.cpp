// SPDX-License-Identifier: MIT
#include "pipeline/study/study.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <functional>
#include <latch>
#include <numeric>
#include <queue>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/json.h"
#include "datasets/base/version.h"

namespace trilat {
namespace {

// Reads digits up to `end`; 0 when there is anything else.
std::uint64_t count_in(const char* begin, const char* end) {
  std::uint64_t value = 0;
  const auto [stop, error] = std::from_chars(begin, end, value);
  return error == std::errc{} && stop == end ? value : 0;
}

}  // namespace

Shard parse_shard(const std::string& text, const std::string& place) {
  const std::size_t slash = text.find('/');
  Shard shard{0, 0};
  if (slash != std::string::npos) {
    shard.number = count_in(text.data(), text.data() + slash);
    shard.of = count_in(text.data() + slash + 1, text.data() + text.size());
  }
  if (shard.number == 0 || shard.number > shard.of || shard.of > kMaxShards)
    throw InputError(place, "is \"" + text + "\"; it must be k/n, shard k of n, 1/n to n/n, n at most " +
                                std::to_string(kMaxShards));
  return shard;
}

std::string name_of(const Shard& shard) {
  return std::to_string(shard.number) + '/' + std::to_string(shard.of);
}

std::vector<std::uint64_t> shards_of(std::span<const double> costs, std::uint64_t shards) {
  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return costs[a] > costs[b]; });
  using Load = std::pair<double, std::uint64_t>;  // cost, shard
  std::priority_queue<Load, std::vector<Load>, std::greater<>> lightest;
  for (std::uint64_t s = 1; s <= std::max<std::uint64_t>(1, shards); ++s) lightest.emplace(0.0, s);
  std::vector<std::uint64_t> result(costs.size());
  for (const std::size_t item : order) {
    const auto [cost, shard] = lightest.top();
    lightest.pop();
    result[item] = shard;
    lightest.emplace(cost + costs[item], shard);
  }
  return result;
}

RunControl control_of(const StudyOptions& options, const std::string& stage) {
  RunControl control{options.stop_requested, {}};
  if (options.progress)
    control.progress = [&options, stage](double share) { options.progress(stage, share); };
  return control;
}

std::string key_of(const Json& settings) {
  return hash_of_text(json_text(Json{{"build", build_id()}, {"settings", settings}}, -1));
}

Json manifest_of(const Json& resolved, const Json& more) {
  Json manifest{{"study", resolved}, {"study_sha256", hash_of_text(resolved.dump())}};
  manifest.update(more);
  return manifest;
}

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
