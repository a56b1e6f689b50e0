// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace trilat {

// `trilat info` of motion capture: format, rate, unit, every asset with samples, gaps, frozen stretches.
int info_of_mocap(const std::filesystem::path& file, bool json);

}  // namespace trilat
