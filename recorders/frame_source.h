// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "datasets/session/host_clock.h"
#include "datasets/session/session_types.h"

namespace trilat {

// Longest time between two looks at a stop request, of everything that waits for a sensor or a link.
inline constexpr std::chrono::milliseconds kPollPeriod{50};

// A depth frame as a source hands it over: kDepthPixels values in millimetres, 0 invalid.
struct DepthFrame {
  FrameStamp stamp;
  std::vector<std::uint16_t> depth_mm;
};

// Something a person should know of a sensor: unplugged, silent, reconnected. Shown and stored.
struct SourceNotice {
  std::string text;
};

// One thing a source delivers, in the order of arrival.
struct SourceEvent {
  std::size_t sensor = 0;
  std::variant<BodyFrame, DepthFrame, ClockExchange, DropCount, SourceNotice> data;
};

// True for a depth frame that is not whole.
inline bool is_torn(const SourceEvent& event) {
  const auto* depth = std::get_if<DepthFrame>(&event.data);
  return depth && depth->depth_mm.size() != kDepthPixels;
}

// Source of frames. The one place for a virtual interface: devices, the network, files and the
// simulator all look the same to the recorder, which stamps, counts and stores without looking inside.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // Known from the start and never changed.
  virtual const SessionHeader& header() const = 0;
  // The next event, waiting for it where necessary; nothing when the source has ended. One thread at a time.
  virtual std::optional<SourceEvent> next() = 0;
  // Makes next() return nothing soon, after what has already been received. Any thread, any number of times.
  virtual void stop() {}
  // True when frames come whether somebody takes them or not, as from a sensor: what the recorder has no room
  // for is then dropped and counted. Otherwise the source waits for the recorder.
  virtual bool live() const { return false; }
};

}  // namespace trilat
