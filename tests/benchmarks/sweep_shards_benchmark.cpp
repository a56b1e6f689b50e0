// SPDX-License-Identifier: MIT
// What it costs to compute a threshold sweep in shards: processor time of all processes against that of one
// run, and what follows for shards of ten seconds.
// Usage: sweep_shards_benchmark TRILAT [TRIALS [SHARDS]]
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "datasets/base/files.h"
#include "tests/benchmarks/program_cost.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

std::string study_of(const std::string& trials) {
  return R"({"format": "trilat.study", "version": 1, "kind": "threshold_sweep", "name": "benchmark",
  "rigs": [{"name": "a", "heights_m": [0.3, 2.3, 0.3, 2.3]}], "gradients": ["corrected"], "trials": )" +
         trials + "}";
}

int run(const std::string& program, const std::string& trials, int shards) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("trilat-benchmark-{}", getpid());
  fs::create_directories(folder);
  const std::string study = folder / "sweep.json";
  write_file(study, study_of(trials));
  const auto run_into = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{program, "run", study,         "--threads",
                                       "1",     "-o",  folder / name, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cost_of(arguments, folder / "stdout.txt");
  };
  const ProgramCost one = run_into("one", {});
  ProgramCost parts;
  std::vector<std::string> merge{program, "merge", "-o", folder / "merged", "--json"};
  for (int k = 1; k <= shards; ++k) {
    merge.push_back(folder / fmt::format("part{}", k));
    parts.add(run_into(fmt::format("part{}", k), {"--shard", fmt::format("{}/{}", k, shards)}));
  }
  const ProgramCost merged = cost_of(merge, folder / "stdout.txt");
  const double each_s = (parts.cpu_s - one.cpu_s) / shards;
  fmt::print("one run: {:.2f} s processor, {:.2f} s wall\n", one.cpu_s, one.wall_s);
  fmt::print("{} shards: {:.2f} s processor, {:.2f} s wall: {:.3f} s more each\n", shards, parts.cpu_s,
             parts.wall_s, each_s);
  fmt::print("merge: {:.3f} s processor, {:.3f} s wall, {} MB\n", merged.cpu_s, merged.wall_s,
             merged.peak_kb / 1024);
  fmt::print("overhead of shards of 10 s: {:.2f} %\n", 10.0 * (each_s + merged.cpu_s / shards));
  const bool same = read_file(folder / "one/summary.json") == read_file(folder / "merged/summary.json");
  fmt::print("merged is {} one run\n", same ? "byte-identical to" : "NOT the same as");
  fs::remove_all(folder);
  return same ? 0 : 1;
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: sweep_shards_benchmark TRILAT [TRIALS [SHARDS]]\n");
    return 2;
  }
  return trilat::run(argv[1], argc > 2 ? argv[2] : "1000000", argc > 3 ? std::atoi(argv[3]) : 64);
}
