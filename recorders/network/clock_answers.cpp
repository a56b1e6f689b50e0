// SPDX-License-Identifier: MIT
#include "datasets/base/error.h"
#include "recorders/network/agent_state.h"
#include "recorders/steady_time.h"

namespace trilat {
namespace {

constexpr std::chrono::milliseconds kAnswerLookPeriod{200};

bool is_over(AgentState& state) {
  const std::lock_guard lock(state.mutex);
  return state.over;
}

void answer_on(AgentState& state, MessageLink& link, const AgentOptions& options) {
  link.send(HelloMessage{LinkRole::clock, options.name, options.incarnation, false, {}});
  while (!is_over(state)) {
    const auto message = link.receive();
    const std::int64_t t2_ns = steady_now_ns();
    if (!message) {
      link.wait(kAnswerLookPeriod);
    } else if (const auto* ping = std::get_if<ClockPingMessage>(&*message)) {
      link.send(ClockPongMessage{ping->id, t2_ns, steady_now_ns()});
    } else if (std::holds_alternative<RefusalMessage>(*message) ||
               std::holds_alternative<ByeMessage>(*message)) {
      return;
    }
  }
}

}  // namespace

void answer_clock_pings(AgentState& state, const AgentOptions& options, const ConnectLink& connect) {
  std::unique_lock lock(state.mutex);
  for (;;) {
    state.changed.wait(lock, [&] { return state.begun || state.over; });
    if (state.over) return;
    lock.unlock();
    try {
      MessageLink link(connect(), options.silence_limit);
      answer_on(state, link, options);
    } catch (const LinkLost&) {
    } catch (const LinkRefused&) {
    } catch (const InputError&) {
    }
    lock.lock();
    state.changed.wait_for(lock, options.first_retry, [&] { return state.over; });
  }
}

}  // namespace trilat
