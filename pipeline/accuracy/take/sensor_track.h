// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "datasets/session/clock/session_clock.h"
#include "datasets/session/session_reader.h"
#include "evaluators/bodies/observed_body.h"

namespace trilat {

// One sensor's body as a function of host time, read from the session block by block. A joint is
// interpolated linearly between two frames that both see it and are no farther apart than `longest_gap`; its
// state is the worse of the two. Of several bodies in a frame the one with the most tracked joints is taken
// (the first of equals), or only those whose tracking id is the person's once choose() said which.
class SensorTrack {
 public:
  SensorTrack(const SessionReader& session, std::size_t sensor, SensorClockMap host_from_sensor,
              Duration longest_gap);

  void choose(std::set<std::uint64_t> tracking_ids) { wanted_ids_ = std::move(tracking_ids); }
  // `t` must not go back from call to call.
  void observe(HostTime t, ObservedBody& body);

 private:
  struct Frame {
    HostTime time;
    ObservedBody body;
  };
  bool load_next();
  Frame frame_from(const BodyFrame& frame);
  const Body* chosen_body(const BodyFrame& frame) const;

  const SessionReader* session_;
  std::size_t sensor_;
  SensorClockMap host_from_sensor_;
  Duration longest_gap_;
  std::optional<std::set<std::uint64_t>> wanted_ids_;  // nothing: any
  std::uint64_t next_row_ = 0;
  std::vector<BodyFrame> block_;
  std::size_t block_position_ = 0;
  Frame before_, after_;  // before_.time <= t < after_.time once both are loaded
  bool has_before_ = false, has_after_ = false, ended_ = false;
};

}  // namespace trilat
