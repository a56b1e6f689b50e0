// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>

#include "recorders/frame_source.h"
#include "recorders/network/agent_book.h"
#include "recorders/network/link/message_link.h"
#include "recorders/network/listen_options.h"

namespace trilat {

// Events from many threads to one, bounded by the bytes they hold. Any thread.
class EventQueue {
 public:
  explicit EventQueue(std::size_t limit_bytes) : limit_bytes_(limit_bytes) {}

  // Waits for room; false when there was none in time or the queue is closed, and `event` is as it was.
  bool push_for(SourceEvent& event, std::chrono::milliseconds at_most);
  // Never waits. False when far too many events are waiting or the queue is closed.
  bool push_small(SourceEvent event);
  // Waits for an event; nothing when the queue is closed and empty.
  std::optional<SourceEvent> pop();
  // Takes no more events.
  void close();
  bool closed() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable not_empty_, not_full_;
  std::deque<SourceEvent> events_;
  std::size_t limit_bytes_;
  std::size_t bytes_ = 0;
  bool closed_ = false;
};

// What all connections of the recording machine share.
struct ServerState {
  explicit ServerState(ListenOptions given)
      : options(std::move(given)),
        queue(options.queue_bytes),
        refusals(options.on_refusal),
        strangers(options.max_pending, options.max_pending_an_address) {}

  const ListenOptions options;
  std::uint64_t recording = 0;
  AgentBook book;
  EventQueue queue;
  RefusalLog refusals;
  PendingStrangers strangers;
  std::atomic<bool> stop{false};
  // The recording has been stopped, and agents send what they hold; then the time for that is over.
  std::atomic<bool> stopping{false}, drain_is_over{false};
  std::vector<std::string> unfinished;  // agents; before the queue is closed
};

// Everything one connection goes through, until it ends. It is no stranger any more when it has said who it
// is.
void serve_connection(ServerState& state, std::unique_ptr<ByteLink> link,
                      const std::shared_ptr<Stranger>& stranger);

// The data connection of an agent that has been admitted; throws LinkLost and LinkRefused.
void serve_agent(ServerState& state, MessageLink& link, AgentSlot& slot);

// Sends pings and delivers clock exchanges for all sensors of the agent; throws LinkLost and LinkRefused.
void serve_clock(ServerState& state, MessageLink& link, const AgentSlot& slot, std::uint64_t connection);

}  // namespace trilat
