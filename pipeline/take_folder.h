// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "pipeline/plan.h"

namespace trilat {

// Takes that are not gathered into one file yet lie in folders below this one.
inline constexpr const char* kTakesFolder = "takes";

// A take's own folder in an unfinished output or a part.
std::filesystem::path own_folder(const std::filesystem::path& output, const std::string& take);

// Where an output has the samples of a take: in its own folder, or among those of all.
std::filesystem::path folder_of_take(const std::filesystem::path& output, const std::string& take);

// Whether all is there that evaluating the take has left in `output`: samples.h5, and replay.h5 when it is
// replayed.
bool holds_take(const Plan& plan, std::size_t take, const std::filesystem::path& output);

}  // namespace trilat
