// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "datasets/import/import_types.h"
#include "datasets/session/session_types.h"

namespace trilat {

// Gives the frames of one stream their stamps, and leaves out those whose time does not go on.
class FrameNumbers {
 public:
  FrameNumbers(double rate_hz, std::int64_t tick_ns) : rate_hz_(rate_hz), tick_ns_(tick_ns) {}

  // Nothing when the frame must be left out; then it has been counted in `left_out` with its place. A
  // sequence number that does not rise is not believed; without one the time says how many frames lie
  // between.
  std::optional<FrameStamp> stamp(std::int64_t ticks, std::optional<std::int64_t> sequence,
                                  const std::string& place, LeftOut& left_out);
  std::int64_t gap_frames() const { return gap_frames_; }

 private:
  double rate_hz_;
  std::int64_t tick_ns_;
  std::optional<FrameStamp> last_{};
  std::int64_t gap_frames_ = 0;
};

// Counts one torn row; the first that is left out keeps its place.
void count_torn(LeftOut& left_out, const std::string& place, const TornRow& row);

}  // namespace trilat
