// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <vector>

#include "datasets/session/session_reader.h"
#include "recorders/frame_source.h"

namespace trilat {

// Frames and clock exchanges of a session once more, sensor against sensor in the order of arrival since each
// one's first frame. Depth comes as it is stored. But for the exchanges, memory does not depend on the
// length.
class ReplaySource : public FrameSource {
 public:
  explicit ReplaySource(const std::filesystem::path& session);
  const SessionHeader& header() const override { return session_.header(); }
  std::optional<SourceEvent> next() override;
  // The earliest time of the host clock in the session; ask before the first event is taken.
  std::int64_t origin_ns() const;

 private:
  struct Stream {
    std::size_t sensor = 0;
    std::uint64_t next_body = 0, next_depth = 0;
    std::deque<BodyFrame> bodies;
    std::deque<FrameStamp> depth_stamps;
    std::deque<ClockExchange> exchanges;
    std::int64_t first_arrival_ns = 0, first_exchange_ns = 0;
  };
  struct Due {
    std::int64_t at_ns = 0;
    int kind = 0;  // 0 an exchange, 1 bodies, 2 depth
  };
  void fill(Stream& stream) const;
  std::optional<Due> due_of(const Stream& stream) const;
  SourceEvent take(Stream& stream, int kind);

  SessionReader session_;
  std::vector<Stream> streams_;
};

}  // namespace trilat
