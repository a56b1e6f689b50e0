// SPDX-License-Identifier: MIT
// How often the intervals of estimate_ray_sigma() hold the simulated truth, and how far off the ratio is.
#include <cstdio>
#include <cstdlib>

#include "tests/evaluators/ray_data.h"

int main(int argc, char** argv) {
  using namespace trilat;
  const std::size_t data_sets = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 1000;
  std::printf("4 sensors, errors of %.1f cm in all\nratio  found from 3000 instants\n", 100.0 * kTotal_m);
  for (const double ratio : {0.05, 0.1, 0.3, 0.5, 1.0, 2.0, 5.0}) {
    const RaySigmaEstimate one = ray_data({.ratio = ratio}, 7).estimate();
    const RaySigmaEstimate shared = ray_data({.ratio = ratio, .shared_m = kTotal_m}, 8).estimate();
    std::printf("%5.2f  %.4f (%.4f to %.4f); half of the variance shared: %.4f\n", ratio, one.ratio_of(),
                one.ratio.low, one.ratio.high, shared.ratio_of());
  }
  std::printf("coverage of 95 %% intervals, %zu data sets of 1000 instants in 20 clusters\n", data_sets);
  for (const double correlation : {0.0, 0.5, 0.8})
    for (const double ratio : {0.2, 0.8, 3.0}) {
      const Coverage c =
          coverage_of_intervals({.ratio = ratio, .instants = 1000, .correlation = correlation}, data_sets);
      std::printf(
          "ratio %.1f, correlation %.1f: ratio %.1f %%, range %.1f %%, bearing %.1f %% (%zu estimated)\n",
          ratio, correlation, 100.0 * c.ratio, 100.0 * c.range, 100.0 * c.bearing, c.estimated);
    }
}
