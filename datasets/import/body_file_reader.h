// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datasets/session/session_types.h"

namespace trilat {

inline constexpr std::int64_t kImportTickNs = 100;  // the Kinect SDK's

using JointPixels = std::array<std::array<double, 2>, kJointCount>;  // column, row in the depth image

// One frame as a file of bodies has it.
struct FileFrame {
  std::int64_t ticks = 0;                  // time of kImportTickNs each, from any origin
  std::optional<std::int64_t> sequence{};  // nothing: follows from the time and the rate
  std::array<float, 4> floor_plane{};
  std::vector<Body> bodies{};
  std::vector<JointPixels> depth_px{};  // one a body, or none at all when the file has none
};

// Somebody's file of tracked bodies, frame by frame; memory does not depend on its length.
class BodyFileReader {
 public:
  virtual ~BodyFileReader() = default;
  // Fills `frame` anew; false at the end. Throws TornRow for a frame that is no use, after which the next
  // call goes on; InputError when the file as a whole cannot be meant.
  virtual bool next(FileFrame& frame) = 0;
  // Where the frame read last stands, for people.
  virtual std::string place() const = 0;
  virtual std::uint64_t bytes_read() const = 0;
};

}  // namespace trilat
