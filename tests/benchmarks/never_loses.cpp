// SPDX-License-Identifier: MIT
// Our minimum against Ceres on hard problems, on all processors; prints the index of every loss.
// Usage: never_loses [FIRST LAST [SEED]]; with one problem (LAST = FIRST + 1) every descent is shown.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tests/evaluators/duel.h"

namespace trilat {
namespace {

constexpr std::uint64_t kChunk = 1000;

std::string text_of(const Eigen::Vector3d& x) {
  return fmt::format("({:.9f}, {:.9f}, {:.9f})", x.x(), x.y(), x.z());
}

void show(std::uint64_t seed, std::uint64_t index) {
  const RangeProblem problem = hard_problem(seed, index);
  const SensorPlane plane = plane_of(problem);
  for (int i = 0; i < problem.count; ++i)
    fmt::print("sensor {} m, range {:.9f} m\n", text_of(problem.sensor_m[i]), problem.range_m[i]);
  fmt::print("scatter {:.3g} {:.3g} {:.3g} m^2\n", plane.scatter_m2[0], plane.scatter_m2[1],
             plane.scatter_m2[2]);
  const std::array<Duel, 2> both = duels(problem);
  fmt::print("start {} m\n", text_of(both[0].start_m));
  for (const Descent& descent : both[0].ceres)
    fmt::print("Ceres to {} m, offset {:+.6f} m, cost {:.17g} m^2, {} after {}\n",
               text_of(descent.position_m), plane.offset_m(descent.position_m), descent.cost_m2,
               name_of(descent.status), descent.iterations);
  for (std::size_t kind = 0; kind < both.size(); ++kind) {
    const PointEstimate& own = both[kind].own;
    fmt::print(
        "{} to {} m, offset {:+.6f} m, cost {:.17g} m^2, {} after {}, gdop {:.3g}, allowance used {:.3g}\n",
        kDuelNames[kind], text_of(own.position_m), plane.offset_m(own.position_m), own.cost_m2,
        name_of(own.status), own.iterations, own.gdop, both[kind].allowance_used());
  }
}

// Chunks go to whoever is free; the tallies do not depend on who that is, but for the order of indices.
DuelTallies tally_by_all(std::uint64_t seed, std::uint64_t first, std::uint64_t last) {
  std::atomic<std::uint64_t> next{first};
  std::mutex mutex;
  DuelTallies total;
  std::uint64_t done = 0;
  const auto start = std::chrono::steady_clock::now();
  const auto work = [&] {
    for (std::uint64_t from = next.fetch_add(kChunk); from < last; from = next.fetch_add(kChunk)) {
      const std::uint64_t to = std::min(from + kChunk, last);
      const DuelTallies tallies = tally_duels(seed, from, to);
      const std::lock_guard lock(mutex);
      for (std::size_t kind = 0; kind < total.size(); ++kind) total[kind].add(tallies[kind]);
      done += to - from;
      const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
      fmt::print(stderr, "\r{} of {}, {} and {} lost, {:.0f} s ", done, last - first, total[0].lost.size(),
                 total[1].lost.size(), spent.count());
    }
  };
  {
    std::vector<std::jthread> threads;
    for (unsigned t = 0; t < std::max(1u, std::thread::hardware_concurrency()); ++t)
      threads.emplace_back(work);
  }
  fmt::print(stderr, "\n");
  return total;
}

void print_indices(const char* what, std::vector<std::uint64_t> indices) {
  std::ranges::sort(indices);
  if (!indices.empty()) fmt::print("  {}: {}\n", what, fmt::join(indices, " "));
}

int run(std::uint64_t first, std::uint64_t last, std::uint64_t seed) {
  if (last == first + 1) {
    show(seed, first);
    return 0;
  }
  const DuelTallies total = tally_by_all(seed, first, last);
  bool sound = true;
  for (std::size_t kind = 0; kind < total.size(); ++kind) {
    total[kind].print(kDuelNames[kind]);
    std::fflush(stdout);
    print_indices("lost", total[kind].lost);
    print_indices("dishonest", total[kind].dishonest);
    sound = sound && total[kind].lost.empty() && total[kind].dishonest.empty();
  }
  return sound ? 0 : 1;
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  const auto number = [&](int i, std::uint64_t otherwise) {
    return argc > i ? std::strtoull(argv[i], nullptr, 10) : otherwise;
  };
  return trilat::run(number(1, 0), number(2, 1'000'000), number(3, 1));
}
