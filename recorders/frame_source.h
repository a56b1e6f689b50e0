// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "datasets/session/session_types.h"

namespace trilat {

// A depth frame as a source hands it over: kDepthPixels values in millimetres, 0 invalid.
struct DepthFrame {
  FrameStamp stamp;
  std::vector<std::uint16_t> depth_mm;
};

// One thing a source delivers, in the order of arrival.
struct SourceEvent {
  std::size_t sensor = 0;
  std::variant<BodyFrame, DepthFrame, ClockExchange, DropCount> data;
};

// Where frames come from. The one place for a virtual interface: devices, the network, files and the
// simulator all look the same to the recorder, which stamps, counts and stores without looking inside.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual const SessionHeader& header() const = 0;
  // The next event; nothing when the source has ended.
  virtual std::optional<SourceEvent> next() = 0;
};

}  // namespace trilat
