// SPDX-License-Identifier: MIT
#include "recorders/network/agent_book.h"

#include <algorithm>
#include <map>
#include <set>

#include "datasets/base/error.h"
#include "datasets/session/session_types.h"
#include "recorders/network/link/socket_link.h"

namespace trilat {

PendingStrangers::PendingStrangers(std::size_t limit, std::size_t limit_an_address)
    : limit_(limit), limit_an_address_(limit_an_address) {}

std::shared_ptr<Stranger> PendingStrangers::add(const std::string& from, std::chrono::milliseconds at_most) {
  std::unique_lock lock(mutex_);
  make_room(from);
  removed_.wait_for(lock, at_most, [&] { return strangers_.size() < 2 * limit_; });
  auto stranger = std::make_shared<Stranger>();
  stranger->from = from;
  strangers_.push_back(stranger);
  return stranger;
}

void PendingStrangers::make_room(const std::string& from) {
  const auto count = [&](const auto& counts) {
    return static_cast<std::size_t>(std::ranges::count_if(strangers_, counts));
  };
  const auto stays = [](const auto& each) { return !each->evicted; };
  const auto stays_from_there = [&](const auto& each) { return !each->evicted && each->from == from; };
  const bool many_from_there = !is_loopback({from, 0}) && count(stays_from_there) >= limit_an_address_;
  if (!many_from_there && count(stays) < limit_) return;
  const auto oldest = many_from_there ? std::ranges::find_if(strangers_, stays_from_there)
                                      : std::ranges::find_if(strangers_, stays);
  if (oldest != strangers_.end()) (*oldest)->evicted = true;
}

void PendingStrangers::remove(const std::shared_ptr<Stranger>& stranger) {
  const std::lock_guard lock(mutex_);
  std::erase(strangers_, stranger);
  removed_.notify_all();
}

namespace {

constexpr std::chrono::seconds kReplaceLimit{3};
constexpr std::chrono::milliseconds kLookPeriod{50};

std::string problem_of(const HelloMessage& hello, const std::string& proven_name) {
  if (hello.agent.empty()) return "an agent needs a name";
  if (!proven_name.empty() && proven_name != hello.agent)
    return "says it is \"" + hello.agent + "\", but its key is that of \"" + proven_name + '"';
  if (hello.sensors.empty()) return "has no sensor";
  std::set<std::string> names;
  for (const SensorDescription& sensor : hello.sensors) {
    if (sensor.name.empty() || sensor.name == "." || sensor.name.find('/') != std::string::npos)
      return "its sensor \"" + sensor.name + "\" must have a name, without '/' and not .";
    if (!names.insert(sensor.name).second) return "has two sensors named \"" + sensor.name + '"';
    const std::string implausible = refusal_of(sensor);
    if (!implausible.empty()) return "its sensor \"" + sensor.name + "\": " + implausible;
  }
  return {};
}

bool same_sensors(const AgentSlot& slot, const HelloMessage& hello) {
  return std::ranges::equal(slot.sensors, hello.sensors,
                            [](const SensorDescription& a, const SensorDescription& b) {
                              return a.serial == b.serial && a.model == b.model && a.tick_ns == b.tick_ns &&
                                     a.has_depth == b.has_depth;
                            });
}

std::unique_ptr<AgentSlot> slot_of(const HelloMessage& hello) {
  auto slot = std::make_unique<AgentSlot>();
  slot->name = hello.agent;
  slot->incarnation = hello.incarnation;
  slot->simulated = hello.simulated;
  slot->sensors = hello.sensors;
  slot->lost.resize(hello.sensors.size());
  slot->earlier.resize(hello.sensors.size());
  return slot;
}

void restart(AgentSlot& slot, std::uint64_t incarnation) {
  slot.incarnation = incarnation;
  slot.next_number = 0;
  slot.said_bye = false;
  for (std::size_t s = 0; s < slot.lost.size(); ++s) {
    slot.earlier[s].at_source += slot.lost[s].at_source;
    slot.earlier[s].in_queue += slot.lost[s].in_queue;
    slot.lost[s] = {};
  }
}

}  // namespace

AgentSlot* AgentBook::find(const std::string& name) {
  const auto slot = std::ranges::find_if(slots_, [&](const auto& each) { return each->name == name; });
  return slot == slots_.end() ? nullptr : slot->get();
}

std::optional<RefusalMessage> AgentBook::refuse_known(AgentSlot& slot, const HelloMessage& hello,
                                                      std::unique_lock<std::mutex>& lock) {
  const RefusalMessage taken{"an agent named \"" + hello.agent + "\" is connected already", true};
  if (slot.incarnation != hello.incarnation && recording_over())
    return RefusalMessage{"the recording is over", false};
  if (!same_sensors(slot, hello)) return RefusalMessage{"has other sensors than before", false};
  if (slot.connected && (slot.incarnation != hello.incarnation || slot.replaced)) return taken;
  slot.replaced = slot.connected;
  const std::string name = slot.name;
  const auto gone = [&] { return !find(name) || !find(name)->connected; };
  if (!changed_.wait_for(lock, kReplaceLimit, gone)) {
    find(name)->replaced = false;
    return taken;
  }
  return std::nullopt;
}

std::variant<AgentSlot*, RefusalMessage> AgentBook::admit(const HelloMessage& hello,
                                                          const std::string& proven_name) {
  const std::string problem = problem_of(hello, proven_name);
  if (!problem.empty()) return RefusalMessage{problem, false};
  std::unique_lock lock(mutex_);
  AgentSlot* slot = find(hello.agent);
  if (slot) {
    if (auto refusal = refuse_known(*slot, hello, lock)) return *refusal;
    slot = find(hello.agent);
  }
  if (!slot) {
    if (begun_) return RefusalMessage{"the recording has begun without this agent", false};
    std::size_t sensors = hello.sensors.size();
    for (const auto& each : slots_) sensors += each->sensors.size();
    if (sensors > kMaxSessionSensors) return RefusalMessage{"a session has at most 64 sensors", false};
    slot = slots_.emplace_back(slot_of(hello)).get();
  }
  slot->restarted = slot->incarnation != hello.incarnation;
  if (slot->restarted) restart(*slot, hello.incarnation);
  slot->connected = true;
  slot->replaced = false;
  changed_.notify_all();
  return slot;
}

void AgentBook::leave(AgentSlot& slot) {
  const std::lock_guard lock(mutex_);
  slot.connected = false;
  slot.lost_at = std::chrono::steady_clock::now();
  if (!begun_) std::erase_if(slots_, [&](const auto& each) { return each.get() == &slot; });
  changed_.notify_all();
}

void AgentBook::say_bye(AgentSlot& slot, const std::string& problem) {
  const std::lock_guard lock(mutex_);
  if (!problem.empty()) slot.source_problem = problem;
  slot.said_bye = true;
}

bool AgentBook::must_leave(const AgentSlot& slot) {
  const std::lock_guard lock(mutex_);
  return slot.replaced;
}

std::optional<std::pair<AgentSlot*, std::uint64_t>> AgentBook::admit_clock(const HelloMessage& hello,
                                                                           const std::string& proven_name) {
  const std::lock_guard lock(mutex_);
  AgentSlot* slot = find(hello.agent);
  const bool known = begun_ && slot && slot->incarnation == hello.incarnation && !slot->said_bye;
  if (!known || (!proven_name.empty() && proven_name != hello.agent)) return std::nullopt;
  return std::pair{slot, ++slot->clock_connections};
}

bool AgentBook::clock_wanted(const AgentSlot& slot, std::uint64_t connection) {
  const std::lock_guard lock(mutex_);
  return slot.clock_connections == connection && !slot.said_bye;
}

bool AgentBook::begin(std::size_t count, std::chrono::milliseconds timeout,
                      const std::function<bool()>& stop) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  std::unique_lock lock(mutex_);
  while (slots_.size() < count) {
    if (stop() || std::chrono::steady_clock::now() >= deadline) return false;
    changed_.wait_for(lock, kLookPeriod);
  }
  name_sensors();
  begun_ = true;
  return true;
}

// The order and the names must not depend on who was first: a calibration goes by them.
void AgentBook::name_sensors() {
  std::ranges::sort(slots_, {}, [](const auto& slot) { return slot->name; });
  std::map<std::string, int> uses;
  for (const auto& slot : slots_)
    for (const SensorDescription& sensor : slot->sensors) ++uses[sensor.name];
  std::set<std::string> names;
  std::size_t first = 0;
  for (const auto& slot : slots_) {
    slot->first_sensor = first;
    first += slot->sensors.size();
    for (SensorDescription& sensor : slot->sensors) {
      if (uses[sensor.name] > 1)
        sensor.name = slot->sensors.size() == 1 ? slot->name : slot->name + '_' + sensor.name;
      if (!names.insert(sensor.name).second || sensor.name.size() > kMaxNameBytes)
        throw InputError("agent " + slot->name, "its sensor cannot be named \"" + sensor.name +
                                                    "\": names must differ and have at most 64 characters");
    }
  }
}

bool AgentBook::begun() {
  const std::lock_guard lock(mutex_);
  return begun_;
}

bool AgentBook::all_said_bye() {
  const std::lock_guard lock(mutex_);
  return recording_over();
}

std::vector<std::string> AgentBook::unfinished() {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const auto& slot : slots_)
    if (!slot->said_bye) names.push_back(slot->name);
  return names;
}

bool AgentBook::recording_over() const {
  return begun_ && std::ranges::all_of(slots_, [](const auto& slot) { return slot->said_bye; });
}

std::vector<std::string> AgentBook::names() {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const auto& slot : slots_) names.push_back(slot->name);
  return names;
}

std::vector<AgentBook::BrokenSource> AgentBook::broken_sources() {
  const std::lock_guard lock(mutex_);
  std::vector<BrokenSource> broken;
  for (const auto& slot : slots_)
    if (!slot->source_problem.empty()) broken.push_back({slot->name, slot->source_problem});
  return broken;
}

std::vector<SensorDescription> AgentBook::sensors() {
  const std::lock_guard lock(mutex_);
  std::vector<SensorDescription> sensors;
  for (const auto& slot : slots_) sensors.insert(sensors.end(), slot->sensors.begin(), slot->sensors.end());
  return sensors;
}

bool AgentBook::simulated() {
  const std::lock_guard lock(mutex_);
  return std::ranges::any_of(slots_, [](const auto& slot) { return slot->simulated; });
}

}  // namespace trilat
