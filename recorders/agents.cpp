// SPDX-License-Identifier: MIT
#include "recorders/agents.h"

#include <algorithm>
#include <cstdlib>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kAckPeriod{200};
constexpr std::uint64_t kMaxUnsynced_bytes = std::uint64_t{4} << 20;
constexpr std::size_t kMaxConnections = 128;

// Whether the other side says goodbye for good, or may try again.
struct Refusal {
  std::string reason;
  bool try_again = false;
};

double age_s(std::chrono::steady_clock::time_point then) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

}  // namespace

std::vector<std::filesystem::path> receive_sockets() {
  std::vector<std::filesystem::path> folders;
  if (const char* folder = std::getenv("XDG_RUNTIME_DIR"); folder && *folder) folders.emplace_back(folder);
  // a login by SSH may lack the variable that the recorder's has
  const std::filesystem::path own = fmt::format("/run/user/{}", ::getuid());
  if (std::filesystem::exists(own)) folders.push_back(own);
  for (std::filesystem::path& folder : folders) folder /= "trilat";
  folders.push_back(fmt::format("/tmp/trilat-{}", ::getuid()));
  for (std::filesystem::path& folder : folders) folder /= "recorder";
  return folders;
}

std::filesystem::path copy_name(const std::filesystem::path& session, const std::string& agent,
                                std::uint64_t log) {
  return fmt::format("{}.{}.{:016x}.trilog", session.string(), agent, log);
}

Agents::Agents(std::unique_ptr<StreamListener> listener, AgentsOptions options)
    : listener_(std::move(listener)), options_(std::move(options)), accepting_([this] { accept_all(); }) {}

Agents::~Agents() {
  ended_ = true;
  accepting_.join();
  for (Connection& connection : connections_) connection.thread.join();
}

std::vector<std::string> Agents::names() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const auto& [name, agent] : agents_)
    if (agent.connection != 0) names.push_back(name);
  return names;
}

// Under the lock.
void Agents::add_notice(const std::string& text) {
  constexpr std::size_t kMaxNotices = 1000;  // kept until take_notices() is called
  if (notices_.size() < kMaxNotices) notices_.push_back(text);
}

void Agents::accept_all() {
  while (!ended_) {
    auto accepted = std::shared_ptr<ByteStream>(listener_->accept(kPollPeriod));
    connections_.remove_if([](Connection& connection) {
      if (connection.done) connection.thread.join();
      return connection.done.load();
    });
    if (!accepted || connections_.size() >= kMaxConnections) continue;
    Connection& connection = connections_.emplace_back();
    try {
      connection.thread = std::thread([this, &connection, accepted] {
        serve(*accepted);
        connection.done = true;
      });
    } catch (const std::system_error&) {
      connections_.pop_back();
    }
  }
}

// One connection, from its first message to its end.
void Agents::serve(ByteStream& stream) {
  const auto refuse = [&](const std::string& who, const Refusal& refusal) {
    {
      const std::lock_guard lock(mutex_);
      add_notice((who.empty() ? "a connection was refused: " : "agent " + who + " was refused: ") +
                 refusal.reason);
    }
    try {
      stream.write_all(encode_message(RefusalMessage{refusal.reason, refusal.try_again}));
    } catch (const LinkLost&) {
    }
  };
  MessageReader reader;
  std::string who;
  try {
    const Clock::time_point start = Clock::now();
    std::optional<Message> first;
    for (std::byte block[1 << 12]; !first && !ended_; first = reader.next()) {
      reader.add(std::span<const std::byte>(block).first(stream.read_some(block, kPollPeriod)));
      if (Clock::now() - start > options_.idle_timeout) return;
    }
    const auto* hello = first ? std::get_if<HelloMessage>(&*first) : nullptr;
    if (!hello) throw BadMessage("does not begin with a hello");
    if (!is_plain_name(hello->agent) || hello->agent.size() > kMaxNameBytes)
      throw BadMessage("an agent's name has letters, digits, '-', '_' and '.'");
    if (hello->role == LinkRole::clock) return answer_pings(stream, reader);
    who = hello->agent;
    receive(stream, reader, *hello, enter(*hello));
  } catch (const Refusal& refusal) {
    refuse(who, refusal);
  } catch (const BadMessage& bad) {
    refuse(who, {bad.what()});
  } catch (const OutputError& error) {
    {
      const std::lock_guard lock(mutex_);
      if (disk_problem_.empty()) disk_problem_ = error.what();
    }
    refuse(who, {error.what(), true});
  } catch (const InputError& error) {
    refuse(who, {error.what()});
  } catch (const LinkLost&) {
  } catch (const std::exception& error) {
    refuse(who, {error.what(), true});
  }
}

void Agents::answer_pings(ByteStream& stream, MessageReader& reader) {
  Clock::time_point heard = Clock::now();
  for (std::byte block[256]; !ended_ && Clock::now() - heard < options_.idle_timeout;) {
    const std::size_t count = stream.read_some(block, kPollPeriod);
    const std::int64_t received_ns = host_now_ns();
    if (count > 0) heard = Clock::now();
    reader.add(std::span<const std::byte>(block).first(count));
    while (const auto message = reader.next())
      if (std::holds_alternative<PingMessage>(*message))
        stream.write_all(encode_message(PongMessage{received_ns, host_now_ns()}));
  }
}

// The number of the agent's new connection. Another connection of the same run of the agent ends; one of
// another run is asked for a sign of life first.
std::uint64_t Agents::enter(const HelloMessage& hello) {
  constexpr milliseconds kSignOfLife{1200};
  const Clock::time_point start = Clock::now();
  while (true) {
    {
      const std::lock_guard lock(mutex_);
      const auto found = agents_.find(hello.agent);
      const bool is_free =
          found == agents_.end() || found->second.connection == 0 || found->second.run == hello.run;
      const bool is_dead = !is_free && begun_ && age_s(found->second.heard) > 1.0;
      if (is_free || is_dead) {
        if (found == agents_.end() && (begun_ || agents_.size() >= options_.count))
          throw Refusal{fmt::format("is not one of the {} agents of this recording", options_.count)};
        Agent& agent = agents_[hello.agent];
        agent.run = hello.run;
        agent.heard = Clock::now();
        return agent.connection = ++connections_made_;
      }
      if (Clock::now() - start > kSignOfLife)
        throw Refusal{"another agent of this name is connected: give each agent a name of its own (--name)"};
    }
    std::this_thread::sleep_for(kPollPeriod);
  }
}

// Under the lock.
Agents::Copy& Agents::copy_of(Agent& agent, const std::string& name, std::uint64_t log) {
  for (Copy& copy : agent.copies)
    if (copy.id == log) return copy;
  Copy& copy = agent.copies.emplace_back();
  try {
    open_copy(agent, copy, name, log);
  } catch (...) {
    agent.copies.pop_back();
    throw;
  }
  return copy;
}

// Under the lock. A copy that an earlier recorder left is gone on with.
void Agents::open_copy(Agent& agent, Copy& copy, const std::string& name, std::uint64_t log) {
  copy.id = log;
  copy.path = copy_name(options_.session, name, log);
  const auto take = [this, &agent, &copy](std::size_t sensor, LogEvent&& event) {
    const auto& sensors = copy.scanner->summary().head.session.sensors;
    if (agent.sensors.size() < sensors.size()) set_sensors(agent, sensors);
    count(agent, sensor, event);
  };
  copy.is_resumed = std::filesystem::exists(copy.path);
  if (copy.is_resumed) {
    const LogEnd end = end_of_event_log(copy.path);
    copy.size = copy.synced = end.offset;
    copy.has_ended = end.finished;
  }
  copy.file = std::make_shared<AppendFile>(
      copy.path, copy.is_resumed ? AppendFile::Open::extend : AppendFile::Open::create, copy.size);
  if (copy.size > 0) {
    LogHead head = head_of_event_log(copy.path);
    set_sensors(agent, head.session.sensors);
    copy.scanner = std::make_unique<LogScanner>(copy.path.string(), take, std::move(head), copy.size);
  } else {
    copy.scanner = std::make_unique<LogScanner>(copy.path.string(), take);
  }
}

void Agents::set_sensors(Agent& agent, const std::vector<SensorDescription>& sensors) {
  if (sensors.size() >= agent.descriptions.size()) agent.descriptions = sensors;
  agent.sensors.resize(std::max(agent.sensors.size(), sensors.size()));
  for (Sensor& sensor : agent.sensors) sensor.heard = Clock::now();
}

void Agents::receive(ByteStream& stream, MessageReader& reader, const HelloMessage& hello,
                     std::uint64_t number) {
  Agent* agent = nullptr;
  Copy* copy = nullptr;
  {
    const std::lock_guard lock(mutex_);
    agent = &agents_.at(hello.agent);
  }
  const auto leave = [&] {
    const std::lock_guard lock(mutex_);
    if (agent->connection == number) agent->connection = 0;
  };
  try {
    bool is_welcome = false;
    Clock::time_point acknowledged{}, heard = Clock::now();
    for (std::vector<std::byte> block(kMaxSentBytes); !ended_;) {
      const std::size_t count = stream.read_some(block, is_welcome ? milliseconds(20) : kPollPeriod);
      reader.add(std::span<const std::byte>(block).first(count));
      if (count > 0) heard = Clock::now();
      // before the recording has begun an agent has nothing to say
      if (copy && Clock::now() - heard > 12 * options_.idle_timeout) throw LinkLost("silent");
      if (begun_ && !is_welcome) {
        std::uint64_t offset = 0;
        if (hello.log != 0 && hello.recording == options_.recording) {
          const std::lock_guard lock(mutex_);
          copy = &copy_of(*agent, hello.agent, hello.log);
          offset = copy->size;
        }
        stream.write_all(encode_message(WelcomeMessage{options_.recording, offset}));
        is_welcome = true;
      }
      while (const auto message = reader.next()) {
        const std::lock_guard lock(mutex_);
        if (agent->connection != number) return;  // another one goes on
        if (count > 0) agent->heard = Clock::now();
        if (copy) take(*agent, *copy, *message);
      }
      sync_and_acknowledge(stream, *agent, copy, number, acknowledged);
    }
  } catch (...) {
    leave();
    throw;
  }
  leave();
}

// Under the lock.
void Agents::take(Agent& agent, Copy& copy, const Message& message) {
  if (const auto* sent = std::get_if<BytesMessage>(&message)) {
    if (sent->offset != copy.size)
      throw BadMessage("sends other bytes of its log than those that are wanted");
    copy.file->append(sent->bytes);
    copy.size += sent->bytes.size();
    copy.frames_held = std::max(copy.frames_held, sent->frames);
    copy.scanner->feed(sent->bytes);
    copy.has_ended = copy.scanner->summary().finished;
  } else if (const auto* live = std::get_if<LiveMessage>(&message)) {
    if (live->sensor < agent.sensors.size()) agent.sensors[live->sensor].newest = live->frame;
  }
}

void Agents::sync_and_acknowledge(ByteStream& stream, Agent& agent, Copy* copy, std::uint64_t number,
                                  Clock::time_point& acknowledged) {
  std::shared_ptr<AppendFile> file;
  std::uint64_t size = 0, synced = 0;
  bool has_ended = false;
  if (copy) {
    const std::lock_guard lock(mutex_);
    file = copy->file;
    size = copy->size;
    synced = copy->synced;
    has_ended = copy->has_ended && !copy->done;
  }
  if (Clock::now() - acknowledged < kAckPeriod && size - synced < kMaxUnsynced_bytes && !has_ended) return;
  if (file && size > synced) file->sync();
  if (copy) {
    const std::lock_guard lock(mutex_);
    if (agent.connection != number) return;
    copy->synced = std::max(copy->synced, size);
  }
  acknowledged = Clock::now();
  stream.write_all(encode_message(AckMessage{size, draining_}));
  if (!copy) return;
  // only then: a recording whose logs are all done ends, and the agent must know that its own is
  const std::lock_guard lock(mutex_);
  copy->done = copy->has_ended && copy->synced == copy->size;
}

// Under the lock.
void Agents::count(Agent& agent, std::size_t s, const LogEvent& event) {
  Sensor& sensor = agent.sensors[s];
  const bool is_bodies = std::holds_alternative<BodyFrame>(event),
             is_depth = std::holds_alternative<EncodedDepthFrame>(event);
  if (is_bodies || is_depth) {
    sensor.heard = Clock::now();
    ++(is_bodies ? sensor.body_frames : sensor.depth_frames);
  }
  if (is_bodies) sensor.newest = std::get<BodyFrame>(event);
  if (const auto* drops = std::get_if<DropCount>(&event)) sensor.drops = *drops;
  if (const auto* text = std::get_if<SensorNotice>(&event)) add_notice(name_of(agent, s) + ": " + text->text);
}

// Under the lock.
std::string Agents::name_of(const Agent& agent, std::size_t sensor) const {
  const auto found =
      std::ranges::find_if(agents_, [&](const auto& entry) { return &entry.second == &agent; });
  return found->first + (agent.sensors.size() > 1 ? "-" + std::to_string(sensor + 1) : "");
}

void Agents::look_after() {
  const std::lock_guard lock(mutex_);
  for (auto& [name, agent] : agents_)
    for (std::size_t s = 0; s < agent.sensors.size(); ++s) {
      Sensor& sensor = agent.sensors[s];
      const bool silent = age_s(sensor.heard) > options_.silence_s &&
                          (agent.copies.empty() || !agent.copies.back().has_ended);
      if (silent == sensor.silent) continue;
      sensor.silent = silent;
      add_notice(name_of(agent, s) +
                 (silent ? fmt::format(": no frame for {:.1f} s{}", options_.silence_s,
                                       agent.connection == 0 ? ", its agent is not connected" : "")
                         : ": frames again"));
    }
}

std::vector<SensorStatus> Agents::status(double period_s) {
  const std::lock_guard lock(mutex_);
  std::vector<SensorStatus> all;
  for (auto& [name, agent] : agents_)
    for (std::size_t s = 0; s < agent.sensors.size(); ++s) {
      Sensor& sensor = agent.sensors[s];
      const double frames =
          static_cast<double>(sensor.body_frames - std::exchange(sensor.at_last_status, sensor.body_frames));
      all.push_back({name_of(agent, s), sensor.body_frames, sensor.depth_frames, sensor.drops.at_source,
                     sensor.drops.in_queue, frames / period_s, std::exchange(sensor.newest, {}),
                     agent.descriptions[s].intrinsics});
    }
  return all;
}

std::vector<std::string> Agents::take_notices() {
  const std::lock_guard lock(mutex_);
  return std::exchange(notices_, {});
}

bool Agents::all_done() const {
  const std::lock_guard lock(mutex_);
  return !agents_.empty() && std::ranges::all_of(agents_, [](const auto& entry) {
    return !entry.second.copies.empty() && entry.second.copies.back().done;
  });
}

void Agents::drain() {
  drain_began_ = Clock::now();
  draining_ = true;
  const auto received = [&] {
    const std::lock_guard lock(mutex_);
    std::uint64_t bytes = 0;
    for (const auto& [name, agent] : agents_)
      for (const Copy& copy : agent.copies) bytes += copy.size;
    return bytes;
  };
  std::uint64_t before = received();
  for (Clock::time_point progress = Clock::now();
       !all_done() && Clock::now() - progress < options_.drain_timeout;) {
    std::this_thread::sleep_for(kPollPeriod);
    if (const std::uint64_t now = received(); now != std::exchange(before, now)) progress = Clock::now();
  }
}

std::vector<LogInput> Agents::logs() const {
  const std::lock_guard lock(mutex_);
  std::vector<LogInput> logs;
  for (const auto& [name, agent] : agents_)
    for (const Copy& copy : agent.copies) {
      LogInput& log = logs.emplace_back(LogInput{copy.path});
      // what another log of the agent goes on behind counts as the gap between them
      if (copy.done || &copy != &agent.copies.back() || agent.sensors.empty()) continue;
      std::int64_t frames = 0, silent = 0;
      for (std::size_t s = 0; s < agent.sensors.size(); ++s) {
        const Sensor& sensor = agent.sensors[s];
        frames += static_cast<std::int64_t>(sensor.body_frames + sensor.depth_frames);
        const double streams = agent.descriptions[s].has_depth ? 2.0 : 1.0;
        const double silent_s = std::chrono::duration<double>(drain_began_ - sensor.heard).count();
        silent += static_cast<std::int64_t>(std::max(0.0, silent_s) * agent.descriptions[s].nominal_rate_hz *
                                            streams);
      }
      const std::int64_t held = copy.is_resumed ? 0 : static_cast<std::int64_t>(copy.frames_held) - frames;
      log.missing_frames = std::max(held, silent);
    }
  return logs;
}

std::string Agents::disk_problem() const {
  const std::lock_guard lock(mutex_);
  return disk_problem_;
}

}  // namespace trilat
