// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/base/json.h"
#include "datasets/results/results_file.h"

namespace trilat {

// Times measured on this machine.
struct SweepTimings {
  static constexpr const char* kFile = "timings.json";
  std::string study;
  std::string processor;
  // Problems of each cell that the scalar solver solved on one thread, the fastest of three times; 0: all
  // trials, made and solved as the run took them.
  std::uint64_t problems = 0;
  std::vector<double> solve_us;  // a solve, start included; of each cell of the summary, in its order

  static void fields(auto& self, auto&& f) {
    f.format("trilat.timings");
    f("study", self.study, "processor", self.processor, "problems", self.problems, "solve_us", self.solve_us);
  }
};

}  // namespace trilat
