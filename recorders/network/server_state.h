// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>

#include "recorders/network/agent_book.h"
#include "recorders/network/event_queue.h"
#include "recorders/network/link/message_link.h"
#include "recorders/network/listen_options.h"
#include "recorders/network/pending_strangers.h"

namespace trilat {

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
