// SPDX-License-Identifier: MIT
#include "recorders/network/server_state.h"
#include "recorders/steady_time.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kClockLookPeriod{100};

struct Ping {
  std::uint64_t id = 0;
  std::int64_t t1_ns = 0;
  bool answered = true;
  Clock::time_point next = Clock::now();
};

void deliver(ServerState& state, const AgentSlot& slot, const ClockExchange& exchange) {
  if (exchange.t1_ns > exchange.t4_ns || exchange.t2_ns > exchange.t3_ns)
    throw LinkRefused("its clock runs backwards");
  for (std::size_t s = 0; s < slot.sensors.size(); ++s)
    state.queue.push_small({slot.first_sensor + s, exchange});
}

void take_answer(ServerState& state, const AgentSlot& slot, const Message& message, Ping& ping) {
  const std::int64_t t4_ns = steady_now_ns();
  if (std::holds_alternative<AliveMessage>(message)) return;
  const auto* pong = std::get_if<ClockPongMessage>(&message);
  if (!pong || pong->id != ping.id || ping.answered) throw LinkRefused("answers what was not asked");
  ping.answered = true;
  deliver(state, slot, {ping.t1_ns, pong->t2_ns, pong->t3_ns, t4_ns});
}

}  // namespace

void serve_clock(ServerState& state, MessageLink& link, const AgentSlot& slot, std::uint64_t connection) {
  Ping ping;
  while (!state.stop && state.book.clock_wanted(slot, connection)) {
    const auto message = link.receive();
    if (message) take_answer(state, slot, *message, ping);
    const auto now = Clock::now();
    if (ping.answered && now >= ping.next) {
      ping = {ping.id + 1, steady_now_ns(), false, std::max(ping.next + state.options.exchange_period, now)};
      link.send(ClockPingMessage{ping.id});
    }
    if (message) continue;
    const auto until_next = std::chrono::ceil<std::chrono::milliseconds>(ping.next - now);
    link.wait(std::clamp(ping.answered ? until_next : kClockLookPeriod, std::chrono::milliseconds(1),
                         kClockLookPeriod));
  }
}

}  // namespace trilat
