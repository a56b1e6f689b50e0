// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "recorders/frame_source.h"
#include "recorders/network/listen_options.h"

namespace trilat {

// What agents send, on the recording machine. Events of one agent come in its order, each exactly once,
// however often its connection breaks; what became of connections comes as notices. Where nobody takes the
// events the agents wait and buffer, so this is no live source. Ends when every agent has said that it is
// done; where a source of theirs broke, next() then says so once with an InputError.
class NetworkSource : public FrameSource {
 public:
  // Listens at once. InputError where the address cannot be had, or plain text is not allowed there.
  explicit NetworkSource(ListenOptions options);
  ~NetworkSource() override;

  std::uint16_t port() const;
  // Waits for `count` agents and fixes who takes part; sensors are in the order of the agents' names.
  // InputError, naming who has come, when there are too few in time; Interrupted when `stop` says so.
  void wait_for_agents(
      std::size_t count, std::chrono::milliseconds timeout,
      const std::function<bool()>& stop = [] { return false; });

  const SessionHeader& header() const override;
  std::optional<SourceEvent> next() override;
  void stop() override;

 private:
  class Listening;
  std::unique_ptr<Listening> listening_;
  SessionHeader header_;
  bool told_what_broke_ = false;
};

}  // namespace trilat
