// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "datasets/results/item_store.h"
#include "datasets/results/take_errors.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/solve_take.h"
#include "pipeline/accuracy/take/take_result.h"
#include "pipeline/errors/take_errors.h"
#include "pipeline/study/run_control.h"

namespace trilat {

// Sends one take through every method and writes its take.h5 into `folder`. Throws Interrupted when asked to
// stop.
TakeResult evaluate_take(const Plan& plan, std::size_t take, const ErrorSettings& errors, bool cross_check,
                         const std::filesystem::path& folder, const RunControl& control);

// The errors of a take that is an item. Where they were made with other settings they are made again from its
// samples, and the item is replaced. InputError when there is no such item.
TakeErrors stored_errors(const ItemStore& store, const std::string& key, const ErrorSettings& settings);

}  // namespace trilat
