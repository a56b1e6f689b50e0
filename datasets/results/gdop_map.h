// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace trilat {

// How well the ranges of a rig fix a point of a horizontal plane: gdop[r * x_m.size() + c] at (x_m[c],
// height, z_m[r]), of the sensors that have the point in view; NaN where fewer than three have, infinite
// where their directions do not span space.
struct GdopMap {
  std::string take;  // whose calibration it is
  double height_m = 0.0;
  std::vector<double> x_m, z_m;
  std::vector<double> gdop;
  std::vector<std::string> sensors;
  std::vector<std::array<double, 3>> position_m;  // of each sensor, world
};

// gdop_map.json, beside the summary.json of a study of kind "accuracy".
void write_gdop_map(const std::filesystem::path& folder, const GdopMap& map);
// Nothing without one; InputError when the file is not one of these.
std::optional<GdopMap> read_gdop_map(const std::filesystem::path& folder);

}  // namespace trilat
