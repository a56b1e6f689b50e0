// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

namespace trilat {

// The frames every number is given in. Names of variables follow them: `point_in_world_m`,
// `world_from_sensor`.
struct FrameDescription {
  std::string_view name;
  std::string_view x;
  std::string_view y;
  std::string_view z;
  std::string_view unit;
  std::string_view origin;
};

inline constexpr std::array<FrameDescription, 4> kFrames{{
    {"world", "OptiTrack x", "up", "right-handed to x and y", "m", "OptiTrack's origin on the floor"},
    {"sensor", "to the sensor's left", "up", "out of the lens", "m",
     "the infrared camera's centre (Kinect camera space)"},
    {"image", "right, with sensor +x", "down, with sensor -y", "-", "px",
     "the centre of the upper left pixel is (0, 0)"},
    {"wand", "to the ball's second place", "on the side of its third place", "right-handed to x and y", "m",
     "the ball's first place"},
}};

}  // namespace trilat
