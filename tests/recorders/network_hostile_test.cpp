// SPDX-License-Identifier: MIT
#include <mutex>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "recorders/network/agent_book.h"
#include "recorders/network/link/message_link.h"
#include "recorders/network/link/socket_link.h"
#include "tests/recorders/network_rig.h"

namespace trilat {
namespace {

using testing::Contains;
using testing::HasSubstr;

// A recording with one honest agent, whose frames go on until end() is called, while a test misbehaves.
class Siege {
 public:
  explicit Siege(std::size_t max_pending = 64, std::chrono::milliseconds handshake_limit = kGenerous)
      : network_(options(max_pending, handshake_limit)),
        source_(
            "kinect", [this](std::size_t number) { return make(number); }, true),
        agent_(source_, agent_options("k1"), connect_as(keys_, "k1", network_.port())) {
    network_.wait_for_agents(1, kGenerous);
    reader_ = std::thread([this] { received_ = receive_all(network_); });
  }
  ~Siege() { end(); }

  // Every frame of the honest agent has arrived, once and in order.
  void expect_nothing_lost() {
    const std::size_t enough = made_ + 20;
    while (made_ < enough) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    end();
    EXPECT_EQ(received_.frames.size(), made_);
    for (std::size_t i = 0; i < received_.frames.size(); ++i)
      ASSERT_TRUE(same_frame(received_.frames[i], made_event(i, 16))) << i;
    EXPECT_TRUE(received_.drops.empty());
  }
  std::vector<std::string> refusals() {
    const std::lock_guard lock(mutex_);
    return refusals_;
  }
  void await_refusal(const std::string& part) {
    const auto deadline = std::chrono::steady_clock::now() + kGenerous;
    while (std::chrono::steady_clock::now() < deadline) {
      for (const std::string& line : refusals())
        if (line.find(part) != std::string::npos) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    FAIL() << "nobody was refused with \"" << part << '"';
  }
  std::unique_ptr<ByteLink> plain() const {
    return connect_socket({"127.0.0.1", network_.port()}, std::chrono::seconds(20));
  }
  std::unique_ptr<MessageLink> secured(const std::string& name) const {
    return std::make_unique<MessageLink>(connect_as(keys_, name, network_.port())(), kGenerous);
  }
  const SessionHeader& header() const { return source_.header(); }
  std::uint16_t port() const { return network_.port(); }

 private:
  ListenOptions options(std::size_t max_pending, std::chrono::milliseconds handshake_limit) {
    ListenOptions listen = listen_options(keys_);
    listen.max_pending = max_pending;
    listen.handshake_limit = handshake_limit;
    listen.on_refusal = [this](const std::string& line) {
      const std::lock_guard lock(mutex_);
      refusals_.push_back(line);
    };
    return listen;
  }
  std::optional<SourceEvent> make(std::size_t number) {
    if (ended_) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    made_ = number + 1;
    return made_event(number, 16);
  }
  void end() {
    ended_ = true;
    if (reader_.joinable()) reader_.join();
  }

  TestKeys keys_;
  std::mutex mutex_;
  std::vector<std::string> refusals_;
  std::atomic<bool> ended_{false};
  std::atomic<std::size_t> made_{0};
  NetworkSource network_;
  MadeSource source_;
  Received received_;
  std::thread reader_;
  RunningAgent agent_;
};

// True when the other side ends the connection, whatever it says before.
bool is_closed(ByteLink& link) {
  const auto deadline = std::chrono::steady_clock::now() + kGenerous;
  std::byte block[4096];
  try {
    while (std::chrono::steady_clock::now() < deadline)
      if (link.try_read(block) == 0) link.wait(false, std::chrono::milliseconds(100));
  } catch (const LinkLost&) {
    return true;
  } catch (const LinkRefused&) {
    return true;
  }
  return false;
}

void write_all(ByteLink& link, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t taken = link.try_write(bytes);
    bytes = bytes.subspan(taken);
    if (taken == 0) link.wait(true, std::chrono::milliseconds(100));
  }
}

// What the recording machine answers to these messages: a refusal, or that it hangs up.
std::string answer_to(MessageLink& link, const std::vector<Message>& messages) {
  const auto deadline = std::chrono::steady_clock::now() + kGenerous;
  try {
    for (const Message& message : messages) link.send(message);
    while (std::chrono::steady_clock::now() < deadline) {
      while (auto message = link.receive())
        if (const auto* refusal = std::get_if<RefusalMessage>(&*message)) return refusal->reason;
      link.wait(std::chrono::milliseconds(100));
    }
  } catch (const LinkLost&) {
    return "hung up";
  } catch (const LinkRefused& refused) {
    return refused.what();
  }
  return "nothing";
}

HelloMessage hello_of(const Siege& siege, const std::string& name, std::uint64_t incarnation = 1) {
  return {LinkRole::data, name, incarnation, false, siege.header().sensors};
}

TEST(NetworkSiege, PlainGarbageIsNoHandshake) {
  Siege siege;
  const auto link = siege.plain();
  write_all(*link, std::vector<std::byte>(3000, std::byte{'G'}));
  EXPECT_TRUE(is_closed(*link));
  siege.await_refusal("TLS");
  siege.expect_nothing_lost();
}

TEST(NetworkSiege, AKeyOfAnotherAuthorityAndNoKeyAreRefused) {
  Siege siege;
  const TestKeys others;
  EXPECT_THROW(connect_as(others, "k2", siege.port())(), LinkRefused);
  siege.await_refusal("TLS");
  siege.expect_nothing_lost();
}

TEST(NetworkSiege, AHugeLengthAndGarbageInsideTlsAreRefused) {
  Siege siege;
  for (const std::byte filler : {std::byte{0xff}, std::byte{0x01}}) {
    auto hostile = siege.secured("k2");
    const auto bytes = std::make_shared<const std::vector<std::byte>>(600, filler);
    hostile->send(bytes);
    EXPECT_EQ(answer_to(*hostile, {}), "hung up");
  }
  siege.await_refusal("bytes is announced");
  siege.expect_nothing_lost();
}

TEST(NetworkSiege, LateAgentsForeignNamesAndDoublesAreToldWhy) {
  Siege siege;
  EXPECT_THAT(answer_to(*siege.secured("k2"), {hello_of(siege, "k2")}), HasSubstr("begun without"));
  EXPECT_THAT(answer_to(*siege.secured("k2"), {hello_of(siege, "k1")}), HasSubstr("key is that of \"k2\""));
  EXPECT_THAT(answer_to(*siege.secured("k1"), {hello_of(siege, "k1", 99)}), HasSubstr("connected already"));
  HelloMessage other = hello_of(siege, "k1");
  other.sensors[0].has_depth = false;
  EXPECT_THAT(answer_to(*siege.secured("k1"), {other}), HasSubstr("other sensors"));
  HelloMessage slow = hello_of(siege, "k2");
  slow.sensors[0].tick_ns = 2'000'000'000;
  EXPECT_THAT(answer_to(*siege.secured("k2"), {slow}), HasSubstr("device tick"));
  slow.sensors[0].tick_ns = 100;
  slow.sensors[0].nominal_rate_hz = 1e5;
  EXPECT_THAT(answer_to(*siege.secured("k2"), {slow}), HasSubstr("frame rate"));
  EXPECT_EQ(answer_to(*siege.secured("k2"), {AckMessage{}}), "hung up");
  HelloMessage clock = hello_of(siege, "k2");
  clock.role = LinkRole::clock;
  EXPECT_THAT(answer_to(*siege.secured("k2"), {clock}), HasSubstr("does not take part"));
  siege.expect_nothing_lost();
}

TEST(NetworkSiege, WhoSaysNothingIsSentAwayInTime) {
  Siege siege(64, std::chrono::milliseconds(700));
  const auto mute = siege.plain();
  const auto mute_in_tls = siege.secured("k2");
  EXPECT_TRUE(is_closed(*mute));
  EXPECT_EQ(answer_to(*mute_in_tls, {}), "hung up");
  siege.expect_nothing_lost();
}

TEST(NetworkSiege, TwoHundredSilentConnectionsDoNotDisturb) {
  Siege siege(16);
  std::vector<std::unique_ptr<ByteLink>> links;
  for (int i = 0; i < 200; ++i) links.push_back(siege.plain());
  siege.await_refusal("too many connections");
  siege.expect_nothing_lost();
}

TEST(NetworkSiege, EightySilentConnectionsDoNotLockAnAgentOut) {
  const TestKeys keys;
  NetworkSource network(listen_options(keys));
  std::atomic<bool> ended{false};
  std::atomic<int> opened{0};
  std::thread flooder([&] {
    std::vector<std::unique_ptr<ByteLink>> links(80);
    std::byte byte[64];
    while (!ended) {
      for (auto& link : links) {
        try {
          if (link) link->try_read(byte);
          if (link) continue;
          link = connect_socket({"127.0.0.1", network.port()}, std::chrono::seconds(5));
          ++opened;
        } catch (const LinkLost&) {
          link.reset();
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  while (opened < 80) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  MadeSource source("kinect", made_events(5));
  AgentOptions options = agent_options("k1");
  RunningAgent agent(source, options, connect_as(keys, "k1", network.port()));
  EXPECT_NO_THROW(network.wait_for_agents(1, std::chrono::seconds(60)));
  ended = true;
  flooder.join();
}

TEST(PendingStrangers, TheOldestMakesRoomAndOneAddressCannotPushOutOthers) {
  PendingStrangers strangers(8, 3);
  const std::chrono::milliseconds at_once{0};
  const auto honest = strangers.add("10.0.0.7", at_once);
  std::vector<std::shared_ptr<Stranger>> flood;
  for (int i = 0; i < 12; ++i) flood.push_back(strangers.add("10.0.0.66", at_once));
  EXPECT_FALSE(honest->evicted);
  for (int i = 0; i < 12; ++i) EXPECT_EQ(flood[static_cast<std::size_t>(i)]->evicted, i < 9) << i;
  for (int i = 0; i < 9; ++i) strangers.remove(flood[static_cast<std::size_t>(i)]);
  for (int i = 0; i < 4; ++i) flood.push_back(strangers.add("127.0.0.1", at_once));
  EXPECT_FALSE(honest->evicted);
  flood.push_back(strangers.add("::ffff:127.0.0.1", at_once));
  EXPECT_TRUE(honest->evicted);
}

TEST(NetworkSiege, RepeatedMessagesDamagedFramesAndASlowReaderDoNotHurt) {
  const TestKeys keys;
  NetworkSource network(listen_options(keys));
  MadeSource honest("own", made_events(100));
  RunningAgent agent(honest, agent_options("k1"), connect_as(keys, "k1", network.port()));
  // never reads until everything is written
  MessageLink hostile(connect_as(keys, "k2", network.port())(), kGenerous);
  const SessionHeader header = MadeSource("other", {}).header();
  hostile.send(HelloMessage{LinkRole::data, "k2", 1, false, header.sensors});
  network.wait_for_agents(2, kGenerous);
  bool welcomed = false;
  while (!welcomed) {
    hostile.wait(std::chrono::milliseconds(100));
    while (auto message = hostile.receive()) welcomed |= std::holds_alternative<WelcomeMessage>(*message);
  }
  EncodedDepthFrame damaged =
      encode_depth_frame(made_stamp(1), made_depth(1).depth_mm, ChunkCompression::blosc);
  damaged.chunk[50] ^= std::byte{1};
  const DepthFrame pixels = made_depth(2);
  const std::vector<Message> messages{
      EventMessage{0, 0, made_bodies(0)},
      EventMessage{0, 0, made_bodies(7)},
      EventMessage{1, 0, damaged},
      EventMessage{2, 0, encode_depth_frame(pixels.stamp, pixels.depth_mm, ChunkCompression::deflate)},
      EventMessage{1, 0, made_bodies(8)},
      EventMessage{9, 0, made_bodies(3)},
      ByeMessage{10},
      ByeMessage{10}};
  for (const Message& message : messages) hostile.send(message);
  std::thread writer([&] {
    try {
      while (hostile.sending()) {
        hostile.wait(std::chrono::milliseconds(50));
        hostile.receive();
      }
    } catch (const LinkLost&) {
    }
  });
  Received received[2];
  while (auto event = network.next()) put(received[event->sensor], std::move(*event));
  writer.join();
  ASSERT_EQ(received[0].frames.size(), 100u);
  ASSERT_EQ(received[1].frames.size(), 3u);
  EXPECT_TRUE(same_frame(received[1].frames[0], {0, made_bodies(0)}));
  EXPECT_TRUE(same_frame(received[1].frames[1], {0, made_depth(2)}));
  EXPECT_EQ(std::get<EncodedDepthFrame>(received[1].frames[1].data).compression, ChunkCompression::blosc);
  EXPECT_TRUE(same_frame(received[1].frames[2], {0, made_bodies(3)}));
  ASSERT_EQ(received[1].drops.size(), 1u);
  EXPECT_EQ(received[1].drops[0].in_queue, 1);
  EXPECT_THAT(received[1].notices, Contains(HasSubstr("damaged")));
}

TEST(NetworkSiege, AFullRingIsCountedToTheFrame) {
  const TestKeys keys;
  ListenOptions listen = listen_options(keys);
  listen.queue_bytes = 5'000;
  NetworkSource network(listen);
  constexpr std::size_t kFrames = 30'000;
  MadeSource source("kinect", made_events(kFrames, 1'000'000), true);
  AgentOptions options = agent_options("k1");
  options.ring_bytes = 300'000;
  RunningAgent agent(source, options, connect_as(keys, "k1", network.port()));
  network.wait_for_agents(1, kGenerous);
  while (agent.link().status().frames_taken < kFrames)  // the sensor is never made to wait
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const Received received = receive_all(network);
  const AgentReport report = agent.report();
  EXPECT_GT(report.status.frames_lost, 0u);
  EXPECT_EQ(received.frames.size() + report.status.frames_lost, kFrames);
  ASSERT_FALSE(received.drops.empty());
  EXPECT_EQ(received.drops.back().in_queue, static_cast<std::int64_t>(report.status.frames_lost));
  EXPECT_THAT(received.notices, Contains(HasSubstr("frames lost, its buffer was full")));
  std::int64_t before = -1;
  for (const SourceEvent& event : received.frames) {
    EXPECT_GT(stamp_of(event).sequence, before);
    before = stamp_of(event).sequence;
  }
}

// Sends the same message as fast as it is taken, until the other side has had enough.
class Flood {
 public:
  Flood(std::unique_ptr<MessageLink> link, const Message& message)
      : link_(std::move(link)), thread_([this, message] { run(message); }) {}
  ~Flood() {
    ended_ = true;
    thread_.join();
  }
  std::size_t sent() const { return sent_; }

 private:
  void run(const Message& message) {
    try {
      while (!ended_) {
        link_->receive();
        while (!link_->sending() && !ended_) {
          link_->send(message);
          ++sent_;
        }
      }
    } catch (const LinkLost&) {
    } catch (const LinkRefused&) {
    }
  }
  std::unique_ptr<MessageLink> link_;
  std::atomic<bool> ended_{false};
  std::atomic<std::size_t> sent_{0};
  std::thread thread_;
};

TEST(NetworkSiege, APeerThatNeverPausesDoesNotKeepTheRecordingMachineFromEnding) {
  for (const bool begun : {false, true}) {
    const TestKeys keys;
    auto network = std::make_unique<NetworkSource>(listen_options(keys));
    auto link = std::make_unique<MessageLink>(connect_as(keys, "k1", network->port())(), kGenerous);
    link->send(HelloMessage{LinkRole::data, "k1", 1, false, MadeSource("kinect", {}).header().sensors});
    if (begun) network->wait_for_agents(1, kGenerous);
    Flood flood(std::move(link), AliveMessage{});
    while (flood.sent() < 10'000) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const auto start = std::chrono::steady_clock::now();
    network.reset();
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60)) << begun;
  }
}

TEST(NetworkSiege, AnAgentStartedAnewWhenAllHaveSaidByeIsRefused) {
  const TestKeys keys;
  NetworkSource network(listen_options(keys));
  MadeSource source("kinect", made_events(5)), again("kinect", made_events(5));
  RunningAgent agent(source, agent_options("k1"), connect_as(keys, "k1", network.port()));
  network.wait_for_agents(1, kGenerous);
  EXPECT_EQ(receive_all(network).frames.size(), 5u);
  EXPECT_EQ(agent.report().end, AgentEnd::complete);
  AgentOptions options = agent_options("k1");
  options.incarnation = 2;
  AgentLink anew(again, options, connect_as(keys, "k1", network.port()));
  try {
    anew.run();
    FAIL() << "the recording is over";
  } catch (const InputError& error) {
    EXPECT_THAT(error.problem(), HasSubstr("the recording is over"));
  }
}

TEST(NetworkSiege, ARefusedAgentSaysWhyAndEnds) {
  Siege siege;
  const TestKeys others;
  MadeSource source("kinect", made_events(3));
  AgentLink stranger(source, agent_options("k2"), connect_as(others, "k2", siege.port()));
  EXPECT_THROW(stranger.run(), InputError);
  siege.expect_nothing_lost();
}

}  // namespace
}  // namespace trilat
