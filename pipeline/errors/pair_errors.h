// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "datasets/results/stored_take.h"
#include "pipeline/errors/take_errors.h"

namespace trilat {

// Distances from the truth of two methods on the samples that both answer, each aligned on just these: one
// that answers less would else be fitted to fewer samples, and look better for it. Sums over a block of time.
struct PairRow {
  std::uint32_t block = 0, quantity = 0, alignment = 0, subset = 0, n = 0;
  double first_m = 0.0, second_m = 0.0;
};

using MethodPair = std::pair<std::uint32_t, std::uint32_t>;  // places in the take's methods
using PairErrors = std::map<MethodPair, std::vector<PairRow>>;

// Errors of some pairs, from the samples; of each an entry, also without any. Reads the file three times,
// from memory where its samples are below 64 MB.
PairErrors pair_errors(const StoredTake& take, const ErrorSettings& settings,
                       std::span<const MethodPair> pairs);

}  // namespace trilat
