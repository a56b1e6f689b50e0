// SPDX-License-Identifier: MIT
#include "datasets/base/error.h"
#include "recorders/frame_source.h"
#include "recorders/network/agent_state.h"

namespace trilat {
namespace {

constexpr std::chrono::milliseconds kLookPeriod{200};

struct AgentTurn {
  AgentState& state;
  MessageLink& link;
  bool welcomed = false;
  bool ended_by_server = false;

  void operator()(const WelcomeMessage& welcome) {
    ResumeMessage resume;
    {
      const std::lock_guard lock(state.mutex);
      if (state.recording && state.recording != welcome.recording) {
        abandon_recording(state);
        throw LinkLost("the recording is gone and another one has begun; " +
                       std::to_string(state.status.frames_lost) + " frames are lost in all");
      }
      if (!state.begun) state.ring.start_over();
      state.recording = welcome.recording;
      state.ring.resume(welcome.next_number);
      resume.lost_frames = state.ring.lost_frames();
      state.status.reconnections += state.begun;
      state.welcomed = true;
      state.begun = true;
      state.changed.notify_all();
    }
    welcomed = true;
    link.send(resume);
  }
  void operator()(const AckMessage& ack) {
    if (!welcomed) return;
    const std::lock_guard lock(state.mutex);
    state.ring.acknowledge(ack.next_number);
    state.changed.notify_all();
  }
  void operator()(const RefusalMessage& refusal) {
    if (refusal.try_again) throw LinkLost(refusal.reason);
    throw LinkRefused(refusal.reason);
  }
  void operator()(const ByeMessage&) {
    ended_by_server = true;
    const std::lock_guard lock(state.mutex);
    const std::uint64_t lost_before = state.ring.lost_frames();
    state.status.frames_lost += lost_before + state.ring.start_over();
  }
  void operator()(const StopMessage&) {
    HeldMessage held;
    {
      const std::lock_guard lock(state.mutex);
      held.end_number = state.ring.end_number();
    }
    link.send(held);
    state.stop();
  }
  // The last recording that this run took part in was abandoned.
  bool in_vain() {
    const std::lock_guard lock(state.mutex);
    return !state.begun && state.status.recordings_abandoned > 0;
  }
  template <class Other>
  void operator()(const Other&) {
    throw LinkRefused("the recording machine says what only agents say");
  }
};

// True when there may be more to send at once.
bool send_some(AgentState& state, MessageLink& link) {
  for (int i = 0; i < kMessagesATurn && !link.sending(); ++i) {
    ResendRing::Bytes bytes;
    {
      const std::lock_guard lock(state.mutex);
      bytes = state.ring.next_to_send();
    }
    if (!bytes) return false;
    link.send(std::move(bytes));
  }
  return !link.sending();
}

bool all_done(AgentState& state) {
  const std::lock_guard lock(state.mutex);
  if (state.over) return true;
  if (!state.begun) return state.stopping || state.source_ended;
  return state.source_ended && state.ring.empty();
}

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

void abandon_recording(AgentState& state) {
  const std::uint64_t lost_before = state.ring.lost_frames();
  state.status.frames_lost += lost_before + state.ring.start_over();
  ++state.status.recordings_abandoned;
  state.recording.reset();
  state.begun = false;
  state.changed.notify_all();
}

AgentEnd serve_agent_link(AgentState& state, MessageLink& link, const HelloMessage& hello) {
  AgentTurn turn{state, link};
  link.send(hello);
  for (;;) {
    bool heard = false;
    for (int i = 0; i < kMessagesATurn; ++i) {
      const auto message = link.receive();
      if (!message) break;
      std::visit(turn, *message);
      heard = true;
    }
    if (all_done(state)) return turn.in_vain() ? AgentEnd::abandoned : AgentEnd::complete;
    if (turn.ended_by_server) return AgentEnd::ended_by_server;
    const bool more = turn.welcomed && send_some(state, link);
    link.send_sign_of_life(AliveMessage{});
    if (!heard && !more) link.wait(kLookPeriod);
  }
}

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
