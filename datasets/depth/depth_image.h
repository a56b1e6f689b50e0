// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace trilat {

// A depth image that somebody else owns: millimetres along z, row by row from the upper left pixel, 0 where
// the sensor saw nothing.
struct DepthImageView {
  int width_px = 0;
  int height_px = 0;
  std::span<const std::uint16_t> depth_mm;

  std::uint16_t at_mm(int column, int row) const {
    return depth_mm[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_px) +
                    static_cast<std::size_t>(column)];
  }
};

}  // namespace trilat
