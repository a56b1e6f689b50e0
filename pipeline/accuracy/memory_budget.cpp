// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/memory_budget.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>

#include <fmt/format.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "evaluators/bodies/observed_body.h"
#include "pipeline/accuracy/methods/over_time.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMega = 1'000'000;
// Measured, with a fifth to spare: looking for persons, exchanges and the clock keeps more than what an
// instant keeps for good; the program itself and reading any take keep some tens of megabytes.
constexpr double kWorkingFactor = 3.0;
constexpr std::uint64_t kTakeBytes = 48 * kMega;

std::uint64_t instant_bytes(const Plan& plan) {
  const std::uint64_t sensors = plan.rig.size(), joints = plan.joints.size();
  const auto over_time = static_cast<std::uint64_t>(
      std::ranges::count_if(plan.methods, [](const Method& m) { return is_over_time(m); }));
  const std::uint64_t view = sizeof(ObservedBody) + kOcclusionRules * kJointCount;
  return sensors * view + joints * sizeof(Eigen::Vector3d) + over_time * joints * sizeof(PathPoint) +
         sizeof(HostTime) + sizeof(float);
}

// A number that stands alone in a file; the largest there is without one, as with "max".
std::uint64_t limit_in(const fs::path& path) {
  std::ifstream file(path);
  std::uint64_t bytes = 0;
  return file >> bytes ? bytes : std::numeric_limits<std::uint64_t>::max();
}

// Of the group this process is in and all above it (version 2), or of a container (version 1).
std::uint64_t group_limit_bytes() {
  const fs::path root = "/sys/fs/cgroup";
  std::uint64_t limit =
      std::min(limit_in(root / "memory.max"), limit_in(root / "memory/memory.limit_in_bytes"));
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (!line.starts_with("0::/")) continue;
    for (fs::path group = line.substr(4); !group.empty(); group = group.parent_path())
      limit = std::min(limit, limit_in(root / group / "memory.max"));
  }
  return limit;
}

}  // namespace

std::uint64_t memory_needed_bytes(const Plan& plan, const PlannedTake& planned) {
  return kTakeBytes + static_cast<std::uint64_t>(kWorkingFactor * static_cast<double>(planned.instants) *
                                                 static_cast<double>(instant_bytes(plan)));
}

std::uint64_t half_of_memory_bytes() {
  const auto machine = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                       static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  return std::min(machine, group_limit_bytes()) / 2;
}

void check_memory(const Plan& plan, const PlannedTake& planned, std::uint64_t limit_bytes) {
  const std::uint64_t need = memory_needed_bytes(plan, planned);
  if (need > limit_bytes)
    throw InputError(planned.take.session.string(),
                     fmt::format("takes about {} MB of memory to evaluate, more than the {} MB allowed: "
                                 "--memory-mb {} allows it, fewer methods or a lower rate_hz take less",
                                 need / kMega + 1, limit_bytes / kMega, need / kMega + 1));
}

std::size_t takes_at_once(const Plan& plan, std::uint64_t limit_bytes) {
  std::vector<std::uint64_t> needs;
  for (const PlannedTake& take : plan.takes)
    if (const std::uint64_t need = memory_needed_bytes(plan, take); take.ok && need <= limit_bytes)
      needs.push_back(need);
  std::ranges::sort(needs, std::greater());
  std::size_t count = 0;
  for (std::uint64_t left = limit_bytes; count < needs.size() && needs[count] <= left; ++count)
    left -= needs[count];
  return std::max<std::size_t>(1, count);
}

}  // namespace trilat
