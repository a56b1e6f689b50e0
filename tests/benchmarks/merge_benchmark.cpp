// SPDX-License-Identifier: MIT
// What merging the parts of an accuracy study costs: bytes of samples a second, memory, and the ratio to
// copying the same samples and doing nothing else. The recording is simulated; all takes are the same one.
// Usage: merge_benchmark TRILAT [SAMPLES [MEMORY_MB [FOLDER]]]
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "datasets/base/files.h"
#include "datasets/results/samples.h"
#include "tests/benchmarks/program_cost.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr int kParts = 4;

constexpr const char* kSimulation =
    R"({"format": "trilat.simulation", "version": 1, "name": "merge benchmark",
  "participants": 1, "activities": [{"name": "walking", "duration_s": 600}],
  "rig": {"radius_m": 2.0, "heights_m": [0.6, 2.2, 0.9, 1.9]}, "body_tracker": {}})";

constexpr const char* kStudy = R"({"format": "trilat.study", "version": 1, "kind": "accuracy",
  "name": "merge benchmark", "alignments": ["mean", "none"], "reference": "mean",
  "methods": [{"name": "linear", "method": "linear"}, {"name": "geometric", "method": "geometric"},
    {"name": "linear, all pairs", "method": "linear", "reference": "all_pairs"},
    {"name": "nonlinear", "method": "nonlinear"}, {"name": "single", "method": "single"},
    {"name": "mean", "method": "mean"}, {"name": "tracked mean", "method": "tracked_mean"},
    {"name": "weighted mean", "method": "weighted_mean"}, {"name": "median", "method": "median"},
    {"name": "mean of three", "method": "mean", "sensors": ["k1", "k2", "k3"]}]})";

std::uint64_t samples_in(const fs::path& folder) {
  const SamplesFile file = SamplesFile::open(folder / "samples.h5");
  std::uint64_t instants = 0;
  for (const TakeShape& take : file.header().takes) instants += take.instants;
  return instants * file.header().joints.size() * file.header().methods.size();
}

// A campaign of `takes` participants, each with the one recording of `folder`.
void multiply_takes(const fs::path& folder, std::uint64_t takes) {
  nlohmann::json campaign = nlohmann::json::parse(read_file(folder / "campaign.json"));
  const nlohmann::json one = campaign["takes"][0];
  campaign["takes"] = nlohmann::json::array();
  for (std::uint64_t t = 1; t <= takes; ++t) {
    nlohmann::json take = one;
    take["participant"] = fmt::format("p{:03}", t);
    take["id"] = fmt::format("p{:03}-walking", t);
    campaign["takes"].push_back(std::move(take));
  }
  write_file(folder / "campaign.json", campaign.dump());
}

double copied_s(const fs::path& folder, const std::vector<std::string>& parts) {
  std::vector<std::string> copy{"/bin/cp", "-r"};
  copy.insert(copy.end(), parts.begin(), parts.end());
  copy.push_back(folder / "copied");
  fs::create_directories(folder / "copied");
  return cost_of(copy, folder / "stdout.txt").wall_s;
}

int run(const std::string& program, double wanted, const std::string& memory_mb, const fs::path& folder) {
  fs::create_directories(folder);
  const std::string study = folder / "study.json", simulation = folder / "simulation.json";
  const std::string campaign = folder / "campaign", merged = folder / "merged";
  write_file(study, kStudy);
  write_file(simulation, kSimulation);
  const fs::path log = folder / "stdout.txt";
  cost_of({program, "simulate", simulation, "-o", campaign}, log);
  cost_of({program, "run", study, "--campaign", campaign, "-o", folder / "one"}, log);
  const std::uint64_t each = samples_in(folder / "one");
  const auto takes = static_cast<std::uint64_t>(wanted / static_cast<double>(each)) + 1;
  multiply_takes(campaign, takes);
  std::vector<std::string> parts;
  for (int k = 1; k <= kParts; ++k) {
    parts.push_back(folder / fmt::format("part{}", k));
    cost_of({program, "run", study, "--campaign", campaign, "--shard", fmt::format("{}/{}", k, kParts), "-o",
             parts.back()},
            log);
  }
  std::vector<std::string> merge{program, "merge", "-o", merged, "--memory-mb", memory_mb};
  merge.insert(merge.end(), parts.begin(), parts.end());
  const double copy_s = copied_s(folder, parts);
  const ProgramCost cost = cost_of(merge, log);
  const double mb = 1e-6 * static_cast<double>(fs::file_size(fs::path(merged) / "samples.h5"));
  fmt::print("{:.3g} samples of {} takes in {} parts, {:.0f} MB (simulated)\n",
             static_cast<double>(each * takes), takes, kParts, mb);
  fmt::print("merge: {:.1f} s wall, {:.1f} s processor, {:.0f} MB/s, peak {} MB\n", cost.wall_s, cost.cpu_s,
             mb / cost.wall_s, cost.peak_kb / 1000);
  fmt::print("copying the parts alone: {:.1f} s wall; merge takes {:.1f} times that\n", copy_s,
             cost.wall_s / copy_s);
  fs::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: merge_benchmark TRILAT [SAMPLES [MEMORY_MB [FOLDER]]]\n");
    return 2;
  }
  const std::filesystem::path folder =
      argc > 4 ? argv[4] : std::filesystem::temp_directory_path() / fmt::format("trilat-merge-{}", getpid());
  return trilat::run(argv[1], argc > 2 ? std::atof(argv[2]) : 1e8, argc > 3 ? argv[3] : "300", folder);
}
