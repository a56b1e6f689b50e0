// SPDX-License-Identifier: MIT
#include "recorders/frame_source.h"
#include "recorders/network/link/tls_link.h"
#include "recorders/network/server_state.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kConnectionLookPeriod{100};
constexpr std::chrono::milliseconds kSeeOffLimit{1000};

// Takes a connection from among the strangers, at once where it says who it is, else when it ends.
class Pending {
 public:
  Pending(PendingStrangers& strangers, const std::shared_ptr<Stranger>& stranger)
      : strangers_(strangers), stranger_(stranger) {}
  ~Pending() { done(); }
  Pending(const Pending&) = delete;
  Pending& operator=(const Pending&) = delete;
  void done() { strangers_.remove(stranger_); }
  bool evicted() const { return stranger_->evicted; }

 private:
  PendingStrangers& strangers_;
  const std::shared_ptr<Stranger>& stranger_;
};

void must_not_be_evicted(const Pending& pending) {
  if (pending.evicted()) throw LinkLost("too many connections that have not said who they are");
}

HelloMessage await_hello(ServerState& state, MessageLink& link, const Pending& pending,
                         Clock::time_point deadline) {
  while (!state.stop) {
    if (auto message = link.receive()) {
      if (auto* hello = std::get_if<HelloMessage>(&*message)) return std::move(*hello);
      throw LinkRefused("began with something else than hello");
    }
    must_not_be_evicted(pending);
    if (Clock::now() >= deadline) throw LinkLost("said nothing in time");
    link.wait(kConnectionLookPeriod);
  }
  throw LinkLost("the recording is over");
}

// Lets the last words arrive: closing at once may throw away what the peer has not read.
void see_off(MessageLink& link, const Message& last_words) {
  const auto deadline = Clock::now() + kSeeOffLimit;
  try {
    link.send(last_words);
    while (Clock::now() < deadline) {
      if (!link.receive()) link.wait(kConnectionLookPeriod);
    }
  } catch (const LinkLost&) {
  } catch (const LinkRefused&) {
  }
}

void tell(ServerState& state, const AgentSlot& slot, const std::string& text) {
  if (state.book.begun())
    state.queue.push_small({slot.first_sensor, SourceNotice{"agent " + slot.name + ": " + text}});
}

void serve_admitted(ServerState& state, MessageLink& link, AgentSlot& slot) {
  std::string problem;
  try {
    serve_agent(state, link, slot);
    if (state.stop || state.drain_is_over || state.queue.closed()) see_off(link, ByeMessage{});
  } catch (const LinkLost& lost) {
    problem = lost.what();
  } catch (const LinkRefused& refused) {
    problem = refused.what();
  } catch (const std::exception& error) {
    problem = std::string("its connection met a bug of the program: ") + error.what();
  }
  if (!problem.empty() && !slot.said_bye) tell(state, slot, "connection lost (" + problem + ')');
  state.book.leave(slot);
}

void serve_hello(ServerState& state, MessageLink& link, const HelloMessage& hello, Pending& pending,
                 const std::string& from) {
  if (hello.role == LinkRole::clock) {
    const auto admitted = state.book.admit_clock(hello, link.peer_name());
    pending.done();
    if (admitted) return serve_clock(state, link, *admitted->first, admitted->second);
    return see_off(link, RefusalMessage{"this agent does not take part", true});
  }
  if (hello.recording != 0 && hello.recording != state.recording) {
    state.refusals.add(from + ": agent \"" + hello.agent +
                       "\" comes from another recording and gets that answer");
    return see_off(link, WelcomeMessage{state.recording, 0});
  }
  const auto admitted = state.book.admit(hello, link.peer_name());
  if (const auto* refusal = std::get_if<RefusalMessage>(&admitted)) {
    state.refusals.add(from + ": agent \"" + hello.agent + "\": " + refusal->reason);
    return see_off(link, *refusal);
  }
  pending.done();
  serve_admitted(state, link, *std::get<AgentSlot*>(admitted));
}

std::unique_ptr<ByteLink> secure(ServerState& state, std::unique_ptr<ByteLink> link, const Pending& pending) {
  if (state.options.keys.empty()) return link;
  try {
    return secure_link(std::move(link), state.options.keys, TlsSide::server, state.options.handshake_limit,
                       [&] { return state.stop || pending.evicted(); });
  } catch (const LinkLost&) {
    must_not_be_evicted(pending);
    throw;
  }
}

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

void serve_connection(ServerState& state, std::unique_ptr<ByteLink> link,
                      const std::shared_ptr<Stranger>& stranger) {
  const std::string& from = stranger->from;
  Pending pending(state.strangers, stranger);
  const auto deadline = Clock::now() + state.options.handshake_limit;
  try {
    MessageLink messages(secure(state, std::move(link), pending), state.options.silence_limit);
    const HelloMessage hello = await_hello(state, messages, pending, deadline);
    serve_hello(state, messages, hello, pending, from);
  } catch (const LinkLost& lost) {
    state.refusals.add(from + ": " + lost.what());
  } catch (const LinkRefused& refused) {
    state.refusals.add(from + ": " + refused.what());
  } catch (const std::bad_alloc&) {
    state.refusals.add(from + ": no memory for this connection");
  } catch (const std::exception& error) {
    state.refusals.add(from + ": this connection met a bug of the program: " + error.what());
  }
}

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
