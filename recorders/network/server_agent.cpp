// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <utility>

#include "recorders/frame_source.h"
#include "recorders/network/server_state.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kAgentLookPeriod{100};
constexpr std::chrono::seconds kTellPeriod{1};
constexpr std::uint64_t kMessagesAnAck = 32;
constexpr std::chrono::milliseconds kCountPeriod{300};  // for messages that were sent and not stored

class AgentIntake {
 public:
  AgentIntake(ServerState& state, MessageLink& link, AgentSlot& slot)
      : state_(state), link_(link), slot_(slot) {}

  // False where the connection has to end in good order.
  bool go_on() const { return !state_.stop && !state_.drain_is_over && !state_.book.must_leave(slot_); }
  bool ended() const { return ended_; }

  void acknowledge(std::uint64_t at_least) {
    if (slot_.next_number - acknowledged_ < at_least) return;
    acknowledged_ = slot_.next_number;
    link_.send(AckMessage{acknowledged_});
  }
  void begin() {
    acknowledged_ = slot_.next_number;
    link_.send(WelcomeMessage{state_.recording, slot_.next_number});
  }

  void operator()(const ResumeMessage& resume) {
    std::uint64_t known = 0;
    for (const DropCount& lost : slot_.lost) known += static_cast<std::uint64_t>(lost.in_queue);
    if (!slot_.lost_at) return;
    const double away_s = std::chrono::duration<double>(Clock::now() - *slot_.lost_at).count();
    char back[64];
    std::snprintf(back, sizeof back, "back after %.1f s, ", away_s);
    const std::uint64_t lost = resume.lost_frames - std::min(known, resume.lost_frames);
    tell(back + (slot_.restarted ? std::string("started anew: what it had not sent is lost")
                 : lost == 0     ? std::string("nothing lost")
                                 : std::to_string(lost) + " frames lost"));
  }
  void operator()(EventMessage& event) {
    if (event.number < slot_.next_number) return;  // sent again, though it had arrived
    if (event.sensor >= slot_.sensors.size()) throw LinkRefused("speaks of a sensor that it does not have");
    const std::size_t sensor = event.sensor;
    std::visit([&](auto& data) { take(sensor, data); }, event.data);
    if (ended_) return;
    slot_.next_number = event.number + 1;
    acknowledge(kMessagesAnAck);
  }
  void operator()(const ByeMessage& bye) {
    if (bye.number < slot_.next_number) return;
    slot_.next_number = bye.number + 1;
    acknowledge(1);
    state_.book.say_bye(slot_, bye.problem);
    if (state_.book.all_said_bye()) state_.queue.close();
  }
  void operator()(const HeldMessage& held) { slot_.held_to = held.end_number; }
  void operator()(const AliveMessage&) {}
  // Once, on this connection.
  void ask_to_stop() {
    if (!std::exchange(asked_to_stop_, true)) link_.send(StopMessage{});
  }
  // Counts what an agent has not sent within the time it had: what is still on the way, and what it holds
  // behind.
  void count_held() {
    if (slot_.said_bye) return;
    const auto until = Clock::now() + kCountPeriod;
    std::uint64_t lost = 0, next_number = slot_.next_number;
    for (auto message = link_.receive(); Clock::now() < until; message = link_.receive()) {
      if (!message) {
        link_.wait(kCountPeriod / 10);
      } else if (const auto* event = std::get_if<EventMessage>(&*message)) {
        if (event->number < next_number) continue;
        next_number = event->number + 1;
        ++lost;
      } else if (const auto* held = std::get_if<HeldMessage>(&*message)) {
        slot_.held_to = held->end_number;
      }
    }
    if (slot_.held_to) lost += *slot_.held_to - std::min(*slot_.held_to, next_number);
    tell((slot_.held_to ? "" : "at least ") + std::to_string(lost) + " messages that it still held are lost");
    slot_.earlier[0].in_queue += static_cast<std::int64_t>(std::max<std::uint64_t>(1, lost));
    state_.queue.push_small({slot_.first_sensor, totals_of(0)});
  }
  template <class Other>
  void operator()(const Other&) {
    throw LinkRefused("says what only the recording machine says");
  }

 private:
  void take(std::size_t sensor, BodyFrame& frame) { put({slot_.first_sensor + sensor, std::move(frame)}); }
  void take(std::size_t, SourceNotice& notice) { tell(notice.text); }
  void take(std::size_t sensor, EncodedDepthFrame& frame) {
    pixels_.resize(kDepthPixels);
    const bool sound =
        slot_.sensors[sensor].has_depth &&
        decode_chunk(frame.chunk, frame.compression, std::as_writable_bytes(std::span(pixels_)));
    if (!sound) {
      ++slot_.earlier[sensor].in_queue;
      tell("a depth frame of " + slot_.sensors[sensor].name + " was damaged and is lost");
      tell_totals(sensor);
      if (ended_) --slot_.earlier[sensor].in_queue;  // it will be sent again
      return;
    }
    if (frame.compression != state_.options.compression)
      frame = encode_depth_frame(frame.stamp, pixels_, state_.options.compression);
    put({slot_.first_sensor + sensor, std::move(frame)});
  }
  void take(std::size_t sensor, const DropCount& count) {
    untold_ += std::max<std::int64_t>(count.in_queue - slot_.lost[sensor].in_queue, 0);
    slot_.lost[sensor] = count;
    if (untold_ > 0 && Clock::now() - told_ >= kTellPeriod) {
      tell(std::to_string(untold_) + " frames lost, its buffer was full");
      untold_ = 0;
      told_ = Clock::now();
    }
    tell_totals(sensor);
  }

  DropCount totals_of(std::size_t sensor) const {
    const DropCount &now = slot_.lost[sensor], &earlier = slot_.earlier[sensor];
    return {steady_now_ns(), now.at_source + earlier.at_source, now.in_queue + earlier.in_queue};
  }
  void tell_totals(std::size_t sensor) { put({slot_.first_sensor + sensor, totals_of(sensor)}); }
  void tell(const std::string& text) {
    state_.queue.push_small({slot_.first_sensor, SourceNotice{"agent " + slot_.name + ": " + text}});
  }
  // Waits for room as long as it takes, and goes on telling the agent that we are there.
  void put(SourceEvent event) {
    while (!state_.queue.push_for(event, kAgentLookPeriod)) {
      ended_ = !go_on() || state_.queue.closed();
      if (ended_) return;
      if (state_.stopping) ask_to_stop();
      link_.send_sign_of_life(AckMessage{slot_.next_number});
    }
  }

  ServerState& state_;
  MessageLink& link_;
  AgentSlot& slot_;
  std::uint64_t acknowledged_ = 0;
  bool ended_ = false, asked_to_stop_ = false;
  std::int64_t untold_ = 0;  // losses that no notice has named
  Clock::time_point told_{};
  std::vector<std::uint16_t> pixels_;
};

// Until the recording begins an agent has nothing to say.
bool await_begin(ServerState& state, MessageLink& link, AgentSlot& slot) {
  while (!state.stop && !state.book.must_leave(slot)) {
    const auto message = link.receive();
    if (message && !std::holds_alternative<AliveMessage>(*message))
      throw LinkRefused("spoke before it was asked");
    if (state.book.begun()) return true;
    link.send_sign_of_life(AckMessage{0});
    if (!message) link.wait(kAgentLookPeriod);
  }
  return false;
}

}  // namespace

void serve_agent(ServerState& state, MessageLink& link, AgentSlot& slot) {
  if (!await_begin(state, link, slot)) return;
  AgentIntake intake(state, link, slot);
  intake.begin();
  while (intake.go_on() && !intake.ended()) {
    bool heard = false;
    for (int i = 0; i < kMessagesATurn && !intake.ended(); ++i) {
      auto message = link.receive();
      if (!message) break;
      std::visit(intake, *message);
      heard = true;
    }
    if (intake.ended()) break;
    if (state.stopping) intake.ask_to_stop();
    intake.acknowledge(1);
    link.send_sign_of_life(AckMessage{slot.next_number});
    if (!heard) link.wait(kAgentLookPeriod);
  }
  if (state.drain_is_over) intake.count_held();
}

}  // namespace trilat
