// SPDX-License-Identifier: MIT
#include "recorders/agent/agent_sender.h"

#include <algorithm>
#include <fstream>
#include <utility>
#include <vector>

#include "datasets/base/error.h"
#include "recorders/frame_source.h"

namespace trilat {
namespace {

using std::chrono::milliseconds;

constexpr std::uint64_t kFarBehind_bytes = std::uint64_t{4} << 20;

// The recorder refuses this agent, for good.
class Refused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

std::vector<std::byte> bytes_at(std::ifstream& file, std::uint64_t offset, std::size_t count) {
  std::vector<std::byte> bytes(count);
  file.clear();
  file.seekg(static_cast<std::streamoff>(offset));
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
  if (file.gcount() != static_cast<std::streamsize>(count))
    throw InputError("the agent's log", "cannot be read back");
  return bytes;
}

}  // namespace

AgentSender::AgentSender(SenderOptions options, Connect connect)
    : options_(std::move(options)),
      connect_(std::move(connect)),
      sending_([this] { keep_connected(); }),
      exchanging_([this] { keep_exchanging(); }) {}

AgentSender::~AgentSender() {
  ended_ = true;
  sending_.join();
  exchanging_.join();
}

void AgentSender::send(SentLog log) {
  const std::lock_guard lock(mutex_);
  log_ = std::move(log);
  acknowledged_ = 0;
}

void AgentSender::show(std::uint8_t sensor, const BodyFrame& frame) {
  const std::lock_guard lock(mutex_);
  live_ = LiveMessage{sensor, frame};
}

std::string AgentSender::refusal() const {
  const std::lock_guard lock(mutex_);
  return refusal_;
}

std::optional<SentLog> AgentSender::log() const {
  const std::lock_guard lock(mutex_);
  return log_;
}

bool AgentSender::pause(milliseconds duration) {
  for (auto left = duration; left.count() > 0 && !ended_; left -= kPollPeriod)
    std::this_thread::sleep_for(std::min(left, kPollPeriod));
  return !ended_;
}

void AgentSender::keep_connected() {
  milliseconds delay = options_.min_retry_delay;
  std::string said;
  bool was_connected = false;
  do {
    std::string problem;
    try {
      const auto stream = connect_();
      if (serve(*stream)) was_connected = true, delay = options_.min_retry_delay;
      continue;  // with a new log, or for good
    } catch (const LinkLost& lost) {
      problem = lost.what();
    } catch (const std::exception&
                 error) {  // a refusal, a program that cannot be run, or a log that cannot be read
      const std::lock_guard lock(mutex_);
      refusal_ = error.what();
      return;
    }
    if (connected_.exchange(false)) was_connected = true, delay = options_.min_retry_delay;
    const std::string news =
        (was_connected ? "the recorder is gone (" : "the recorder does not answer yet (") + problem +
        "); trying again";
    if (news != std::exchange(said, news)) options_.on_status_change(news);
    if (!pause(delay)) return;
    delay = std::min(2 * delay, options_.last_retry);
  } while (!ended_);
}

void AgentSender::receive(ByteStream& stream, MessageReader& reader, milliseconds at_most) {
  std::byte block[1 << 12];
  const std::size_t count = stream.read_some(block, at_most);
  reader.add(std::span<const std::byte>(block).first(count));
  if (count > 0) heard_ = Clock::now();
  if (Clock::now() - heard_ > options_.idle_timeout) throw LinkLost("it has fallen silent");
}

void AgentSender::take(const Message& message) {
  if (const auto* ack = std::get_if<AckMessage>(&message)) {
    const std::lock_guard lock(mutex_);
    acknowledged_ = std::max<std::uint64_t>(acknowledged_, ack->synced);
    if (ack->stop) stop_asked_ = true;
  } else if (const auto* refusal = std::get_if<RefusalMessage>(&message)) {
    if (refusal->try_again) throw LinkLost(refusal->reason);
    throw Refused(refusal->reason);
  }
}

// Offset at which to go on in the log. Waits for the beginning of the recording, in which the recorder gives
// signs of life.
std::uint64_t AgentSender::wait_for_welcome(ByteStream& stream, MessageReader& reader,
                                            const std::optional<SentLog>& log) {
  stream.write_all(encode_message(HelloMessage{LinkRole::data, options_.name, options_.run, log ? log->id : 0,
                                               log ? log->recording : 0}));
  heard_ = Clock::now();
  while (!ended_) {
    receive(stream, reader, kPollPeriod);
    try {
      while (const auto message = reader.next()) {
        if (const auto* welcome = std::get_if<WelcomeMessage>(&*message)) {
          recording_ = welcome->recording;
          if (!connected_.exchange(true)) options_.on_status_change("the recorder takes what comes");
          return welcome->offset;
        }
        take(*message);
      }
    } catch (const BadMessage& bad) {
      throw Refused(std::string("what answers is not this version's recorder: ") + bad.what());
    }
  }
  return 0;
}

// One connection. True when it was ended by this side: there is another log to be sent, or an end.
bool AgentSender::serve(ByteStream& stream) {
  MessageReader reader;
  std::optional<SentLog> log = this->log();
  std::uint64_t at = wait_for_welcome(stream, reader, log);
  while (!ended_ && (!log || log->recording != recording_)) {  // until there is a log of that recording
    receive(stream, reader, milliseconds(20));
    while (const auto message = reader.next()) take(*message);
    log = this->log();
    if (log && log->recording == recording_) return true;  // say hello with it
  }
  std::ifstream file;
  Clock::time_point shown = Clock::now();
  while (!ended_) {
    receive(stream, reader, milliseconds(0));
    while (const auto message = reader.next()) take(*message);
    const std::uint64_t there = log->written_bytes();
    std::optional<LiveMessage> live;
    {
      const std::lock_guard lock(mutex_);
      if (!log_ || log_->id != log->id) return true;
      if (there - at > kFarBehind_bytes && Clock::now() - shown > options_.exchange_period)
        live = std::exchange(live_, {});
    }
    if (live) {
      stream.write_all(encode_message(*live));
      shown = Clock::now();
    }
    if (at < there) {
      if (!file.is_open()) file.open(log->path, std::ios::binary);
      const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(there - at, kMaxSentBytes));
      stream.write_all(encode_message(BytesMessage{at, log->frames(), bytes_at(file, at, count)}));
      at += count;
    } else {
      receive(stream, reader, milliseconds(10));
    }
  }
  return true;
}

// Failures are the sending thread's to report.
void AgentSender::keep_exchanging() {
  while (pause(options_.exchange_period)) {
    if (!connected_) continue;
    try {
      exchange_stamps(*connect_());
    } catch (const std::exception&) {
      pause(options_.last_retry);
    }
  }
}

// Two pings at once: the recorder's answer to the first and what it received of the second are the stamps of
// an exchange that the recorder began.
void AgentSender::exchange_stamps(ByteStream& stream) {
  MessageReader reader;
  stream.write_all(encode_message(HelloMessage{LinkRole::clock, options_.name, options_.run, 0, recording_}));
  const auto ping = [&](std::int64_t& sent_ns, std::int64_t& answered_ns) {
    sent_ns = host_now_ns();
    stream.write_all(encode_message(PingMessage{}));
    const Clock::time_point start = Clock::now();
    std::byte block[256];
    while (!ended_ && Clock::now() - start < options_.idle_timeout) {
      reader.add(std::span<const std::byte>(block).first(stream.read_some(block, kPollPeriod)));
      answered_ns = host_now_ns();
      while (const auto message = reader.next()) {
        if (const auto* pong = std::get_if<PongMessage>(&*message)) return *pong;
        take(*message);
      }
    }
    throw LinkLost("no answer");
  };
  do {
    std::int64_t first_sent_ns = 0, first_answered_ns = 0, second_sent_ns = 0, second_answered_ns = 0;
    const PongMessage first = ping(first_sent_ns, first_answered_ns);
    const PongMessage second = ping(second_sent_ns, second_answered_ns);
    options_.on_exchange({first.sent_ns, first_answered_ns, second_sent_ns, second.received_ns});
  } while (pause(options_.exchange_period) && connected_);
}

}  // namespace trilat
