// SPDX-License-Identifier: MIT
// How often methods put a simulated joint on the wrong side of the plane of sensors that stand at nearly
// equal heights, how many they answer, and how far off the answers are. Usage: wrong_sides [RIGS
// [JOINTS_A_RIG]]
#include <cstdlib>

#include <fmt/format.h>

#include "tests/evaluators/flat_rigs.h"

int main(int argc, char** argv) {
  using namespace trilat;
  const std::uint64_t rigs = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 200;
  const auto joints = static_cast<std::uint32_t>(argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 500);
  fmt::print(
      "simulated: {} rigs x {} joints more than {:.0f} cm off the sensors' plane, seen {:.0f} cm off an "
      "axis\n",
      rigs, joints, 100.0 * kOffPlane_m, 100.0 * kSeenSigma_m);
  fmt::print("{:24} {:22} {:>10} {:>12} {:>10}\n", "heights", "method", "answered", "wrong side", "MAE");
  for (const RigFamily& family : rig_families())
    for (const SideMethod& method : side_methods()) {
      const SideTally tally = tally_sides(family, method, rigs, joints);
      fmt::print("{:24} {:22} {:8.1f} % {:10.2f} % {:7.2f} cm\n", family.name, method.name,
                 100.0 * tally.answered / tally.asked, 100.0 * tally.wrong_share(),
                 100.0 * tally.error_m / tally.answered);
    }
}
