// SPDX-License-Identifier: MIT
#include "recorders/agent/run_agent.h"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <random>
#include <system_error>
#include <thread>
#include <utility>

#include "datasets/base/error.h"

namespace trilat {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr milliseconds kNewsPeriod{250};

std::string name_of_log(const std::string& agent, std::uint64_t id) {
  char text[128];
  std::snprintf(text, sizeof text, "%.64s.%016llx.trilog", agent.c_str(),
                static_cast<unsigned long long>(id));
  return text;
}

// One run of an agent.
class Agent {
 public:
  Agent(const std::vector<std::unique_ptr<FrameSource>>& source, const AgentOptions& options)
      : source_(source), options_(options) {
    if (!options.connect) return;
    SenderOptions link = options.link;
    link.name = options.name;
    link.run = std::uint64_t{std::random_device{}()} << 32 | std::random_device{}();
    link.on_status_change = options.on_status_change;
    link.on_exchange = [this](const ClockExchange& exchange) {
      const std::lock_guard lock(spool_mutex_);
      if (spool_) spool_->add_exchange(exchange);
    };
    sender_.emplace(std::move(link), options.connect);
  }

  AgentReport run() {
    if (!wait_for_recording()) return {};
    begin_log();
    {
      const std::lock_guard lock(spool_mutex_);
      spool_.emplace(source_, log_, options_.spool);
    }
    record();
    spool_->count_silence_to_the_end();
    spool_->look_after();
    AgentReport report = counts();
    report.source_problem = spool_->source_problem();
    if (const std::string problem = spool_->log_problem(); !problem.empty())
      throw OutputError(log_path_.string(), problem);
    log_->finish(report.source_problem);
    if (sender_) wait_until_sent();
    keep_or_remove();
    report.left = left_;
    return report;
  }

 private:
  // False when it was stopped before.
  bool wait_for_recording() {
    while (sender_ && sender_->recording() == 0) {
      if (options_.stop_requested()) return false;
      if (const std::string refusal = sender_->refusal(); !refusal.empty())
        throw InputError("the recorder", refusal);
      std::this_thread::sleep_for(kPollPeriod);
    }
    return true;
  }

  void begin_log() {
    recording_ = sender_ ? sender_->recording() : 0;
    const LogHead head = new_log_head(joint_header(source_), recording_, options_.name);
    log_path_ = options_.folder / name_of_log(options_.name, head.id);
    const auto log = std::make_shared<EventLogWriter>(log_path_, head);
    if (spool_) spool_->go_on_in(log);
    const std::uint64_t before = spool_ ? spool_->frames() : 0;
    log_ = log;
    if (!sender_) return;
    sender_->send({log_path_, head.id, recording_, [log] { return log->written_bytes(); },
                   [this, before] {
                     const std::lock_guard lock(spool_mutex_);
                     return spool_ ? spool_->frames() - before : 0;
                   }});
  }

  void record() {
    Clock::time_point looked = Clock::now(), shown = looked;
    bool stopped = false;
    while (!spool_->wait_for_end(kPollPeriod)) {
      if (!stopped && (options_.stop_requested() || (sender_ && sender_->stop_asked()))) {
        stopped = true;
        spool_->stop();
      }
      if (Clock::now() - looked < kNewsPeriod) continue;
      looked = Clock::now();
      spool_->look_after();
      for (const std::string& text : spool_->take_notices()) options_.on_status_change(text);
      show_newest();
      mind_disk();
      if (sender_ && sender_->recording() != recording_) change_log();
      if (const std::string refusal = sender_ ? sender_->refusal() : "";
          !std::exchange(is_refused_, !refusal.empty()) && is_refused_)
        options_.on_status_change("the recorder refuses this agent: " + refusal +
                                  "; it goes on recording into " + log_path_.string());
      if (Clock::now() - shown > std::chrono::seconds(10)) {
        shown = Clock::now();
        options_.on_status_change(status_text());
      }
    }
  }

  void show_newest() {
    const std::vector<SensorStatus> sensors = spool_->status(1.0);
    for (std::size_t s = 0; sender_ && s < sensors.size(); ++s)
      if (sensors[s].newest_bodies) sender_->show(static_cast<std::uint8_t>(s), *sensors[s].newest_bodies);
  }

  // The recording of the log is gone, and another one has begun.
  void change_log() {
    const std::shared_ptr<EventLogWriter> before = log_;
    const std::filesystem::path path = log_path_;
    const std::uint64_t acknowledged = sender_->acknowledged();
    begin_log();
    before->finish();
    if (before->written_bytes() > acknowledged)
      left_.push_back({path, before->written_bytes() - acknowledged});
    options_.on_status_change("another recording has begun; what the one before did not take lies in " +
                              path.string());
  }

  // Room is made by dropping what the recorder has; where that is not enough, frames are dropped and counted.
  void mind_disk() {
    std::error_code error;
    const auto space = std::filesystem::space(options_.folder, error);
    if (error) return;
    if (space.available < options_.reserve_bytes && sender_) log_->release(sender_->acknowledged());
    const bool full = space.available < options_.reserve_bytes / 4;
    if (full != std::exchange(is_full_, full))
      options_.on_status_change(full ? "the disk is full: frames are lost, and counted"
                                     : "the disk has room again");
    spool_->set_disk_full(full);
  }

  void wait_until_sent() {
    Clock::time_point progress = Clock::now();
    for (std::uint64_t before = 0; sender_->acknowledged() < log_->written_bytes();) {
      if (std::exchange(before, sender_->acknowledged()) != sender_->acknowledged()) progress = Clock::now();
      if (Clock::now() - progress > options_.shutdown_timeout || !sender_->refusal().empty()) return;
      if (sender_->recording() != recording_) return;
      std::this_thread::sleep_for(kPollPeriod);
    }
  }

  void keep_or_remove() {
    const std::uint64_t size = log_->written_bytes();
    const std::uint64_t acknowledged = sender_ ? sender_->acknowledged() : 0;
    sender_.reset();
    log_.reset();
    spool_.reset();
    if (options_.connect && acknowledged == size)
      std::filesystem::remove(log_path_);
    else
      left_.push_back({log_path_, size - acknowledged});
  }

  AgentReport counts() {
    AgentReport report;
    report.was_recorded = true;
    report.frames = spool_->frames();
    for (const SensorStatus& sensor : spool_->status(1.0)) {
      report.lost_at_source += sensor.lost_at_source;
      report.lost_in_queue += sensor.lost_in_queue;
    }
    return report;
  }

  std::string status_text() {
    const AgentReport now = counts();
    char text[160];
    const double behind_mb =
        sender_ ? 1e-6 * static_cast<double>(log_->written_bytes() - sender_->acknowledged()) : 0.0;
    std::snprintf(text, sizeof text, "%s; %llu frames taken, %lld lost, %.1f MB not sent",
                  !sender_               ? "recording alone"
                  : sender_->connected() ? "recording"
                                         : "not connected",
                  static_cast<unsigned long long>(now.frames),
                  static_cast<long long>(now.lost_at_source + now.lost_in_queue), behind_mb);
    return text;
  }

  const std::vector<std::unique_ptr<FrameSource>>& source_;
  const AgentOptions& options_;
  std::uint64_t recording_ = 0;
  std::filesystem::path log_path_;
  std::shared_ptr<EventLogWriter> log_;
  std::vector<LeftLog> left_;
  bool is_full_ = false, is_refused_ = false;
  std::mutex spool_mutex_;  // of the optional, which the sender's threads look into
  std::optional<Spool> spool_;
  std::optional<AgentSender> sender_;  // the last: its threads use all of the above
};

}  // namespace

bool AgentReport::whole() const {
  return lost_at_source == 0 && lost_in_queue == 0 && source_problem.empty() && left.empty();
}

AgentReport run_agent(const std::vector<std::unique_ptr<FrameSource>>& source, const AgentOptions& options) {
  return Agent(source, options).run();
}

}  // namespace trilat
