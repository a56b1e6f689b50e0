// SPDX-License-Identifier: MIT
// Agents and a recorder in one process: links that break, logs that are joined, who is let in.
#include "recorders/agents.h"

#include <future>
#include <thread>

#include <gmock/gmock.h>
#include <unistd.h>

#include "datasets/base/philox.h"
#include "datasets/session/session_reader.h"
#include "recorders/agent/run_agent.h"
#include "recorders/capture.h"
#include "tests/recorders/pattern_source.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using std::chrono::milliseconds;
using testing::Contains;
using testing::HasSubstr;

TEST(ReceiveSockets, LieInAFolderOfTheUsersOwnWhateverTheLoginKnows) {
  const std::vector<std::filesystem::path> sockets = receive_sockets();
  ASSERT_FALSE(sockets.empty());
  EXPECT_EQ(sockets.back(), "/tmp/trilat-" + std::to_string(::getuid()) + "/recorder");
  for (const std::filesystem::path& socket : sockets) EXPECT_EQ(socket.filename(), "recorder");
}

// A recorder on a thread of its own.
class Recorder {
 public:
  Recorder(std::filesystem::path session, std::size_t agents, CaptureOptions options = {})
      : session_(std::move(session)) {
    options.agents = agents;
    options.look_period_s = 0.05;
    options.wait_s = 30.0;
    options.on_notice = [this](const std::string& text) {
      const std::lock_guard lock(mutex_);
      notices_.push_back(text);
    };
    options.stop_requested = [this] { return stop_.load(); };
    options.listen = [this] {
      auto listener = std::make_unique<StreamListener>(SocketAddress{"127.0.0.1", 0});
      port_ = listener->port();
      return listener;
    };
    summary_ = std::async(std::launch::async, [this, options] { return capture({}, session_, options); });
  }
  ~Recorder() { stop(); }

  Connect connect() {
    return [this] {
      while (port_ == 0) std::this_thread::sleep_for(milliseconds(1));
      return connect_loopback({"127.0.0.1", port_});
    };
  }
  void stop() { stop_ = true; }
  CaptureSummary wait() { return summary_.get(); }
  std::vector<std::string> notices() {
    const std::lock_guard lock(mutex_);
    return notices_;
  }

 private:
  std::filesystem::path session_;
  std::atomic<std::uint16_t> port_{0};
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::vector<std::string> notices_;
  std::future<CaptureSummary> summary_;
};

// A source at 300 frames a second, stamped with this machine's clock.
class QuickSource : public PatternSource {
 public:
  explicit QuickSource(std::int64_t frames, std::size_t sensors = 1)
      : PatternSource(sensors, frames), sensors_(sensors) {}
  std::optional<SourceEvent> next() override {
    while (true) {
      auto event = PatternSource::next();
      if (!event || !std::holds_alternative<ClockExchange>(event->data)) return stamped(std::move(event));
    }
  }

 private:
  std::optional<SourceEvent> stamped(std::optional<SourceEvent> event) {
    if (events_++ % (2 * sensors_) == 0) std::this_thread::sleep_for(milliseconds(3));
    if (!event) return event;
    if (auto* frame = std::get_if<BodyFrame>(&event->data)) frame->stamp.arrival_ns = host_now_ns();
    if (auto* frame = std::get_if<DepthFrame>(&event->data)) frame->stamp.arrival_ns = host_now_ns();
    return event;
  }
  std::size_t sensors_, events_ = 0;
};

std::vector<std::unique_ptr<FrameSource>> source_of(std::int64_t frames, std::size_t sensors = 1) {
  std::vector<std::unique_ptr<FrameSource>> sources;
  sources.push_back(std::make_unique<QuickSource>(frames, sensors));
  return sources;
}

AgentOptions agent_named(const std::string& name, const ScratchFolder& folder, Connect connect) {
  AgentOptions options;
  options.name = name;
  options.folder = folder.path();
  options.connect = std::move(connect);
  options.link.min_retry_delay = milliseconds(10);
  options.link.last_retry = milliseconds(50);
  options.link.idle_timeout = milliseconds(2000);
  options.link.exchange_period = milliseconds(20);
  return options;
}

// All frames of the pattern, once each, in their order and with their content.
void expect_whole(const SessionReader& session, std::size_t sensor, std::size_t pattern,
                  std::uint64_t frames) {
  ASSERT_EQ(session.counts(sensor).body_frames, frames);
  ASSERT_EQ(session.counts(sensor).depth_frames, frames);
  const auto bodies = session.body_frames(sensor, 0, frames);
  std::vector<std::uint16_t> depth(kDepthPixels);
  for (std::size_t i = 0; i < frames; ++i) {
    const auto frame = static_cast<std::int64_t>(i);
    ASSERT_EQ(bodies[i].stamp.sequence, frame);
    ASSERT_EQ(bodies[i].bodies.size(), static_cast<std::size_t>(frame % 3));
    if (!bodies[i].bodies.empty()) {
      ASSERT_EQ(bodies[i].bodies[0].position_m,
                PatternSource::bodies_of(pattern, frame).bodies[0].position_m);
    }
    session.depth_frame(sensor, i, depth);
    ASSERT_EQ(depth, PatternSource::depth_of(pattern, frame));
  }
}

std::size_t logs_in(const ScratchFolder& folder) {
  std::size_t logs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    logs += entry.path().extension() == ".trilog";
  return logs;
}

TEST(Agents, SensorsOfTwoComputersBecomeOneSessionNamedByTheirAgents) {
  const ScratchFolder folder;
  Recorder recorder(folder / "s.h5", 2);
  auto left = std::async(std::launch::async, [&] {
    return run_agent(source_of(40), agent_named("left", folder, recorder.connect()));
  });
  const AgentReport right = run_agent(source_of(30, 2), agent_named("right", folder, recorder.connect()));
  EXPECT_TRUE(left.get().whole());
  EXPECT_TRUE(right.whole());
  EXPECT_EQ(right.frames, 120u);
  const CaptureSummary summary = recorder.wait();
  EXPECT_EQ(summary.end, CaptureEnd::source_ended);
  EXPECT_FALSE(summary.lost_frames());
  EXPECT_EQ(summary.log_left, "");
  const SessionReader session(folder / "s.h5");
  ASSERT_EQ(session.header().sensors.size(), 3u);
  EXPECT_TRUE(session.header().simulated);
  for (const auto& [name, pattern, frames] :
       {std::tuple{"left", 0, 40}, std::tuple{"right-1", 0, 30}, std::tuple{"right-2", 1, 30}})
    expect_whole(session, session.sensor_index(name), static_cast<std::size_t>(pattern),
                 static_cast<std::uint64_t>(frames));
  const auto exchanges = session.clock_exchanges(session.sensor_index("left"));
  ASSERT_GE(exchanges.size(), 2u);
  for (const ClockExchange& e : exchanges) {
    EXPECT_LE(e.t1_ns, e.t2_ns);  // one machine, one clock
    EXPECT_LE(e.t2_ns, e.t3_ns);
    EXPECT_LE(e.t3_ns, e.t4_ns);
  }
  EXPECT_EQ(logs_in(folder), 0u);
}

// Fails once it has carried so many bytes.
class BrittleStream : public ByteStream {
 public:
  BrittleStream(std::unique_ptr<ByteStream> inner, std::size_t bytes)
      : inner_(std::move(inner)), left_(bytes) {}
  std::size_t read_some(std::span<std::byte> into, milliseconds at_most) override {
    return inner_->read_some(into, at_most);
  }
  void write_all(std::span<const std::byte> from) override {
    const std::size_t taken = std::min(left_, from.size());
    inner_->write_all(from.first(taken));
    left_ -= taken;
    if (taken < from.size()) throw LinkLost("cut");
  }

 private:
  std::unique_ptr<ByteStream> inner_;
  std::size_t left_;
};

TEST(Agents, ALinkThatIsCutThirtyTimesLosesAndRepeatsNothing) {
  const ScratchFolder folder;
  Recorder recorder(folder / "s.h5", 1);
  std::atomic<std::uint32_t> connections{0};
  const auto brittle = [&, connect = recorder.connect()]() -> std::unique_ptr<ByteStream> {
    const std::uint32_t number = connections++;
    const RandomStream random{1, Purpose::sensor_drop, 0};
    const double bytes = number < 60 ? 100.0 + random.uniform(number) * 600e3 : 1e12;
    return std::make_unique<BrittleStream>(connect(), static_cast<std::size_t>(bytes));
  };
  const AgentReport report = run_agent(source_of(120), agent_named("k1", folder, brittle));
  EXPECT_TRUE(report.whole());
  EXPECT_FALSE(recorder.wait().lost_frames());
  EXPECT_GT(connections, 30u);
  expect_whole(SessionReader(folder / "s.h5"), 0, 0, 120);
  EXPECT_EQ(logs_in(folder), 0u);
}

TEST(Agents, AfterAnOutageTheRecordingHasAllOfIt) {
  const ScratchFolder folder;
  Recorder recorder(folder / "s.h5", 1);
  std::atomic<bool> out{false};
  const auto connect = [&, inner = recorder.connect()]() -> std::unique_ptr<ByteStream> {
    if (out) throw LinkLost("an outage");
    return std::make_unique<BrittleStream>(inner(), 2'000'000);  // some 20 frames
  };
  std::vector<std::string> news;
  AgentOptions options = agent_named("k1", folder, connect);
  std::mutex mutex;
  options.on_status_change = [&](const std::string& text) {
    const std::lock_guard lock(mutex);
    news.push_back(text);
  };
  auto agent = std::async(std::launch::async, [&] { return run_agent(source_of(400), options); });
  std::this_thread::sleep_for(milliseconds(300));
  out = true;
  std::this_thread::sleep_for(milliseconds(700));
  out = false;
  EXPECT_TRUE(agent.get().whole());
  EXPECT_FALSE(recorder.wait().lost_frames());
  expect_whole(SessionReader(folder / "s.h5"), 0, 0, 400);
  EXPECT_THAT(news, Contains(HasSubstr("the recorder is gone (")));
}

TEST(Agents, StopDrainsWhatAgentsHold) {
  const ScratchFolder folder;
  Recorder recorder(folder / "s.h5", 1);
  auto agent = std::async(std::launch::async, [&] {
    return run_agent(source_of(1'000'000), agent_named("k1", folder, recorder.connect()));
  });
  std::this_thread::sleep_for(milliseconds(600));
  recorder.stop();
  const CaptureSummary summary = recorder.wait();
  const AgentReport report = agent.get();
  EXPECT_TRUE(report.whole());
  EXPECT_EQ(summary.end, CaptureEnd::stop_requested);
  EXPECT_FALSE(summary.lost_frames());
  const SessionReader session(folder / "s.h5");
  EXPECT_EQ(session.counts(0).body_frames + session.counts(0).depth_frames, report.frames);
  expect_whole(session, 0, 0, session.counts(0).body_frames);
}

// Of an agent whose process is killed when `killed` is set: it says nothing more.
class MortalStream : public ByteStream {
 public:
  MortalStream(std::unique_ptr<ByteStream> inner, const std::atomic<bool>& killed)
      : inner_(std::move(inner)), killed_(killed) {}
  std::size_t read_some(std::span<std::byte> into, milliseconds at_most) override {
    if (killed_) throw LinkLost("killed");
    return inner_->read_some(into, at_most);
  }
  void write_all(std::span<const std::byte> from) override {
    if (killed_) throw LinkLost("killed");
    inner_->write_all(from);
  }

 private:
  std::unique_ptr<ByteStream> inner_;
  const std::atomic<bool>& killed_;
};

// Runs an agent for so long and kills it.
void run_and_kill(const std::string& name, const ScratchFolder& folder, const Connect& connect,
                  milliseconds after, std::size_t sensors = 1) {
  std::atomic<bool> killed{false};
  AgentOptions agent = agent_named(name, folder, [&]() -> std::unique_ptr<ByteStream> {
    if (killed) throw LinkLost("killed");
    return std::make_unique<MortalStream>(connect(), killed);
  });
  agent.shutdown_timeout = milliseconds(50);
  agent.stop_requested = [&] { return killed.load(); };
  auto run = std::async(std::launch::async, [&] { return run_agent(source_of(1'000'000, sensors), agent); });
  std::this_thread::sleep_for(after);
  killed = true;
  EXPECT_EQ(run.get().left.size(), 1u);
}

TEST(Agents, AnAgentThatIsKilledHasLostWhatItWouldHaveDelivered) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.duration_s = 4.0;
  Recorder recorder(folder / "s.h5", 1, options);
  run_and_kill("k1", folder, recorder.connect(), milliseconds(800));
  const CaptureSummary summary = recorder.wait();
  ASSERT_EQ(summary.last.sensors.size(), 1u);
  // some 3 s of bodies and of depth at 30 Hz, without the time in which the recorder waited for what would
  // still come
  EXPECT_GE(summary.last.sensors[0].lost_in_queue, 2 * 30);
  EXPECT_LE(summary.last.sensors[0].lost_in_queue, 2 * 30 * 4);
  EXPECT_EQ(SessionReader(folder / "s.h5").drop_counts(0).back().in_queue,
            summary.last.sensors[0].lost_in_queue);
  const std::string notice = "k1: no frame for 1.5 s, its agent is not connected";
  const auto notices = recorder.notices();
  EXPECT_EQ(std::ranges::count(notices, notice), 1);
}

TEST(Agents, ASecondRunOfAnAgentIsJoinedAndTheGapCounted) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.duration_s = 5.0;
  Recorder recorder(folder / "s.h5", 1, options);
  run_and_kill("k1", folder, recorder.connect(), milliseconds(800));
  std::this_thread::sleep_for(milliseconds(1500));
  auto second = std::async(std::launch::async, [&] {
    return run_agent(source_of(1'000'000), agent_named("k1", folder, recorder.connect()));
  });
  const CaptureSummary summary = recorder.wait();
  EXPECT_TRUE(second.get().whole());
  ASSERT_EQ(summary.last.sensors.size(), 1u);
  // at least 1.5 s of bodies and of depth at 30 Hz
  EXPECT_GE(summary.last.sensors[0].lost_at_source, 2 * 40);
  EXPECT_LE(summary.last.sensors[0].lost_at_source, 2 * 150);
  const SessionReader session(folder / "s.h5");
  EXPECT_EQ(session.drop_counts(0).back().at_source, summary.last.sensors[0].lost_at_source);
  std::string notices;
  for (const SensorNotice& notice : session.notices(0)) notices += notice.text + "\n";
  EXPECT_THAT(notices, HasSubstr("s between two logs were not recorded"));
}

TEST(Agents, ASecondRunMayHaveFewerSensors) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.duration_s = 2.5;
  std::atomic<std::uint64_t> looks{0};
  options.on_status = [&](const CaptureStatus& status) { looks += status.sensors.size(); };
  Recorder recorder(folder / "s.h5", 1, options);
  run_and_kill("k1", folder, recorder.connect(), milliseconds(600), 2);
  run_agent(source_of(1'000'000), agent_named("k1", folder, recorder.connect()));
  recorder.wait();
  EXPECT_GT(looks, 0u);
  const SessionReader session(folder / "s.h5");
  for (const char* name : {"k1", "k1-1", "k1-2"})
    EXPECT_GT(session.counts(session.sensor_index(name)).body_frames, 0u);
}

// Breaks after 20 events.
class BreakingSource : public QuickSource {
 public:
  BreakingSource() : QuickSource(1000) {}
  std::optional<SourceEvent> next() override {
    if (events_++ == 20) throw std::runtime_error("the cable was pulled");
    return QuickSource::next();
  }

 private:
  int events_ = 0;
};

TEST(Agents, ASourceThatBreaksFailsTheRecordingToo) {
  const ScratchFolder folder;
  Recorder recorder(folder / "s.h5", 1);
  std::vector<std::unique_ptr<FrameSource>> source;
  source.push_back(std::make_unique<BreakingSource>());
  EXPECT_EQ(run_agent(source, agent_named("k1", folder, recorder.connect())).source_problem,
            "the cable was pulled");
  EXPECT_TRUE(recorder.wait().source_failed);
  EXPECT_THAT(SessionReader(folder / "s.h5").notices(0).at(0).text, HasSubstr("the cable was pulled"));
}

// The host clock of a machine begins anew with it, and exchanges with two host clocks would give wrong times.
TEST(Agents, ARecordingIsNotGoneOnWithAfterAStartOfTheMachine) {
  const ScratchFolder folder;
  LogHead head = new_log_head({});
  head.recording = head.id;
  head.start_ns += 1'000'000'000'000;
  EventLogWriter(folder / "s.h5.trilog", head).finish();
  CaptureOptions options;
  options.agents = 1;
  EXPECT_THAT(message_of([&] { capture({}, folder / "s.h5", options); }),
              HasSubstr("was begun before this machine was started anew"));
}

TEST(Agents, OnlyWhoBelongsThereIsLetIn) {
  const ScratchFolder folder;
  const ScratchFolder& other = folder;
  Recorder recorder(folder / "s.h5", 1);
  auto agent = std::async(std::launch::async, [&] {
    return run_agent(source_of(1'000'000), agent_named("k1", folder, recorder.connect()));
  });
  std::this_thread::sleep_for(milliseconds(300));
  EXPECT_THAT(message_of([&] { run_agent(source_of(10), agent_named("k1", other, recorder.connect())); }),
              HasSubstr("another agent of this name is connected"));
  EXPECT_THAT(message_of([&] { run_agent(source_of(10), agent_named("k2", other, recorder.connect())); }),
              HasSubstr("is not one of the 1 agents of this recording"));
  const auto answer_to = [&](std::vector<std::byte> bytes) -> std::string {
    const auto stranger = recorder.connect()();
    stranger->write_all(bytes);
    MessageReader reader;
    std::byte block[1024];
    try {
      for (int look = 0; look < 50; ++look) {
        reader.add(std::span<const std::byte>(block).first(stranger->read_some(block, milliseconds(50))));
        if (const auto message = reader.next()) return std::get<RefusalMessage>(*message).reason;
      }
    } catch (const LinkLost&) {
    }
    return "none";
  };
  std::vector<std::byte> old = encode_message(HelloMessage{LinkRole::data, "k1", 1, 0, 0});
  old[9] = std::byte{4};
  EXPECT_THAT(answer_to(old), HasSubstr("speaks version 5 of the protocol, not 4"));
  EXPECT_THAT(answer_to(encode_message(HelloMessage{LinkRole::data, "../k1", 1, 0, 0})),
              HasSubstr("an agent's name has"));
  EXPECT_THAT(answer_to(encode_message(AckMessage{})), HasSubstr("does not begin with a hello"));
  EXPECT_THAT(answer_to(std::vector<std::byte>(100, std::byte{'G'})), HasSubstr("too long"));
  std::vector<std::unique_ptr<ByteStream>> silent;
  for (int i = 0; i < 200; ++i) silent.push_back(recorder.connect()());
  std::this_thread::sleep_for(milliseconds(300));
  recorder.stop();
  EXPECT_FALSE(recorder.wait().lost_frames());
  EXPECT_TRUE(agent.get().whole());
  EXPECT_THAT(recorder.notices(), Contains(HasSubstr("not 4")));
}

TEST(Agents, WhoDoesNotComeIsNamedWithThoseThatDid) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.agents = 2;
  options.wait_s = 0.5;
  std::atomic<std::uint16_t> port{0};
  options.listen = [&] {
    auto listener = std::make_unique<StreamListener>(SocketAddress{"127.0.0.1", 0});
    port = listener->port();
    return listener;
  };
  std::atomic<bool> stop{false};
  AgentOptions agent = agent_named("left", folder, [&]() -> std::unique_ptr<ByteStream> {
    if (port == 0) throw LinkLost("not yet");
    return connect_loopback({"127.0.0.1", port});
  });
  agent.stop_requested = [&] { return stop.load(); };
  auto run = std::async(std::launch::async, [&] { return run_agent(source_of(10), agent); });
  EXPECT_THAT(message_of([&] { capture({}, folder / "s.h5", options); }),
              HasSubstr("2 agents were awaited for 0 s, came: left"));
  stop = true;
  EXPECT_FALSE(run.get().was_recorded);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Agents, AloneAnAgentRecordsIntoALogThatIsJoinedLater) {
  const ScratchFolder folder;
  std::vector<LogInput> logs;
  for (const char* name : {"left", "right"}) {
    const AgentReport report = run_agent(source_of(20), agent_named(name, folder, {}));
    EXPECT_EQ(report.frames, 40u);
    ASSERT_EQ(report.left.size(), 1u);
    logs.push_back({report.left[0].path});
  }
  EXPECT_TRUE(write_session(logs, folder / "s.h5").whole());
  const SessionReader session(folder / "s.h5");
  ASSERT_EQ(session.header().sensors.size(), 2u);
  expect_whole(session, session.sensor_index("left"), 0, 20);
  expect_whole(session, session.sensor_index("right"), 0, 20);
}

}  // namespace
}  // namespace trilat
