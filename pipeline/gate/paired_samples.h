// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/gate/found_results.h"
#include "pipeline/gate/paired_cells.h"

namespace trilat {

struct PairedSamples {
  PairedStudy study;
  std::uint64_t takes_with_other_instants = 0;  // cannot be paired and are left out
  std::string first_with_other_instants;
  std::uint64_t truths_that_differ = 0;  // samples, of those that both nights have a truth for
};

// Streams both nights' samples.h5 side by side: the same take, instant, joint and method. InputError when
// they do not hold the same takes, joints and methods.
PairedSamples read_paired_samples(const ResultsPair& pair);

}  // namespace trilat
