// SPDX-License-Identifier: MIT
#include "recorders/network/agent_link.h"

#include <algorithm>
#include <new>
#include <optional>
#include <thread>
#include <vector>

#include "datasets/base/error.h"
#include "recorders/network/agent_state.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

bool is_frame(const SourceEvent& event) {
  return std::holds_alternative<BodyFrame>(event.data) ||
         std::holds_alternative<EncodedDepthFrame>(event.data) ||
         (std::holds_alternative<DepthFrame>(event.data) && !is_torn(event));
}

// Under the mutex of the state.
void wake_all(AgentState& state) {
  state.changed.notify_all();
  if (state.link) state.link->wake();
}

}  // namespace

AgentLink::AgentLink(FrameSource& source, AgentOptions options, ConnectLink connect)
    : source_(source),
      options_(std::move(options)),
      connect_(std::move(connect)),
      state_(
          std::make_unique<AgentState>(source.header().sensors.size(), options_.ring_bytes, source.live())) {
  state_->stop = [this] { stop(); };
}

AgentLink::~AgentLink() = default;

AgentReport AgentLink::run() {
  std::vector<std::thread> threads;
  AgentReport report;
  std::exception_ptr error;
  try {
    threads.emplace_back([this] { guard([this] { pump(); }); });
    threads.emplace_back([this] { guard([this] { compress(); }); });
    threads.emplace_back([this] { guard([this] { answer_clock_pings(*state_, options_, connect_); }); });
    report.end = keep_connected();
  } catch (...) {
    error = std::current_exception();
  }
  end_all();
  for (std::thread& thread : threads) thread.join();
  if (thread_error_) std::rethrow_exception(thread_error_);
  if (error) std::rethrow_exception(error);
  try {
    if (source_error_) std::rethrow_exception(source_error_);
  } catch (const InputError& broken) {
    report.source_problem = broken.what();
  }
  report.status = status();
  return report;
}

// A thread that cannot go on ends the link; run() says why.
void AgentLink::guard(const std::function<void()>& body) {
  try {
    body();
  } catch (...) {
    {
      const std::lock_guard lock(state_->mutex);
      if (!thread_error_) thread_error_ = std::current_exception();
    }
    end_all();
  }
}

void AgentLink::end_all() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->over = state_->stopping = true;
    wake_all(*state_);
  }
  source_.stop();
}

void AgentLink::stop() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
    wake_all(*state_);
  }
  source_.stop();
}

AgentStatus AgentLink::status() const {
  const std::lock_guard lock(state_->mutex);
  AgentStatus status = state_->status;
  status.connected = state_->link != nullptr;
  status.recording = state_->begun;
  status.frames_lost += state_->ring.lost_frames();
  status.buffered_bytes = state_->ring.bytes();
  return status;
}

void AgentLink::pump() {
  {
    std::unique_lock lock(state_->mutex);
    state_->changed.wait(lock, [&] { return state_->begun || state_->stopping; });
  }
  std::string problem;
  try {
    take_events();
  } catch (const std::exception& error) {
    source_error_ = std::current_exception();
    problem = *error.what() ? error.what() : "for no stated reason";
  }
  const std::lock_guard lock(state_->mutex);
  if (!problem.empty()) state_->ring.push({0, SourceNotice{"the source broke: " + problem}});
  state_->ring.push_bye(problem);
  state_->source_ended = Clock::now();
  wake_all(*state_);
}

void AgentLink::take_events() {
  for (;;) {
    {
      std::unique_lock lock(state_->mutex);
      if (!source_.live())
        state_->changed.wait(lock,
                             [&] { return state_->stopping || (state_->begun && !state_->ring.full()); });
      if (state_->stopping) return;
    }
    auto event = source_.next();
    if (!event) return;
    const std::lock_guard lock(state_->mutex);
    const bool total = std::holds_alternative<DropCount>(event->data);
    if (!state_->begun && !total) continue;  // between two recordings
    if (is_frame(*event)) ++state_->status.frames_taken;
    state_->ring.push(std::move(*event));
    wake_all(*state_);
  }
}

void AgentLink::compress() {
  std::unique_lock lock(state_->mutex);
  while (!state_->over) {
    auto pixels = state_->ring.fetch_pixels();
    if (!pixels) {
      state_->changed.wait(lock);
      continue;
    }
    lock.unlock();
    std::optional<EncodedDepthFrame> frame;
    try {
      frame = encode_depth_frame(pixels->second.stamp, pixels->second.depth_mm, options_.compression);
    } catch (const std::bad_alloc&) {
    }
    lock.lock();
    if (frame)
      state_->ring.put_compressed(pixels->first, std::move(*frame));
    else
      state_->ring.lose_pixels(pixels->first);
    wake_all(*state_);
  }
}

AgentEnd AgentLink::keep_connected() {
  std::string last_problem;
  auto delay = options_.first_retry;
  for (;;) {
    bool welcomed = false;
    std::string problem;
    try {
      return connect_once(welcomed);
    } catch (const LinkLost& lost) {
      problem = lost.what();
    } catch (const LinkRefused& refused) {
      problem = refused.what();
      if (!status().recording) throw InputError("the recording machine", "refuses this agent: " + problem);
    } catch (const InputError& error) {
      problem = error.what();
      if (!status().recording) throw;
    }
    if (welcomed) delay = options_.first_retry;
    if (welcomed || problem != last_problem) options_.on_news("not connected: " + problem);
    last_problem = problem;
    if (!wait_to_retry(delay)) return lost_recording() ? AgentEnd::abandoned : AgentEnd::unacknowledged;
    delay = std::min(2 * delay, options_.last_retry);
  }
}

bool AgentLink::lost_recording() const {
  const std::lock_guard lock(state_->mutex);
  return state_->status.recordings_abandoned > 0 && !state_->begun;
}

// False when there is nothing to retry for.
bool AgentLink::wait_to_retry(std::chrono::milliseconds delay) {
  const auto now = Clock::now();
  std::unique_lock lock(state_->mutex);
  const auto in_vain = [&] {
    return state_->over || (!state_->begun && (state_->stopping || state_->source_ended));
  };
  if (state_->changed.wait_until(lock, now + delay, in_vain)) return false;
  if (!state_->source_ended) return true;
  return Clock::now() - std::max(*state_->source_ended, state_->last_connected) < options_.farewell_limit;
}

AgentEnd AgentLink::connect_once(bool& welcomed) {
  MessageLink link(connect_(), options_.silence_limit);
  const SessionHeader& header = source_.header();
  HelloMessage hello{LinkRole::data, options_.name, options_.incarnation, header.simulated, header.sensors};
  {
    const std::lock_guard lock(state_->mutex);
    state_->link = &link;
    hello.recording = state_->recording.value_or(0);
  }
  struct Disconnect {
    AgentState& state;
    ~Disconnect() {
      const std::lock_guard lock(state.mutex);
      state.link = nullptr;
      if (state.welcomed) state.last_connected = Clock::now();
      state.welcomed = false;
    }
  };
  const Disconnect at_end{*state_};
  try {
    return serve_agent_link(*state_, link, hello);
  } catch (const std::runtime_error&) {
    const std::lock_guard lock(state_->mutex);
    welcomed = state_->welcomed;
    throw;
  }
}

}  // namespace trilat
