// SPDX-License-Identifier: MIT
// How often range_bearing ends in a minimum that is not the lowest, on ten rigs.
#include "tests/evaluators/global_minima.h"

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  const std::size_t problems = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 2000;
  const std::size_t starts = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 60;
  std::size_t missed = 0;
  for (const auto& [name, loss] :
       {std::pair{"squares", trilat::Loss::squares}, {"cauchy", trilat::Loss::cauchy}}) {
    const trilat::GlobalCheck check = trilat::check_global_minima(problems, starts, loss);
    std::printf("%s: %zu problems on 10 rigs, %zu random starts each: %zu missed, the worst by %.3f m\n",
                name, check.problems, starts, check.missed, check.worst_m);
    missed += check.missed;
  }
  return missed == 0 ? 0 : 1;
}
