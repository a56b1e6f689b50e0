// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "recorders/network/network_source.h"
#include "recorders/synthetic_source.h"
#include "tests/recorders/cutting_proxy.h"
#include "tests/recorders/network_rig.h"

namespace trilat {
namespace {

using testing::Contains;
using testing::HasSubstr;

void expect_made_frames(const Received& received, std::size_t count, std::size_t depth_every = 8) {
  ASSERT_EQ(received.frames.size(), count);
  for (std::size_t i = 0; i < count; ++i)
    ASSERT_TRUE(same_frame(received.frames[i], made_event(i, depth_every))) << "frame " << i;
}

SyntheticSource two_virtual_sensors() {
  const SensorSpec spec;
  const SimulatedItem item{7, 0, 0};
  std::vector<SimulatedSensor> sensors;
  for (const SensorPose& pose : rig_poses({}, {0.0, 1.0, 0.0}))
    if (sensors.size() < 2) sensors.push_back(draw_sensor(spec, item, sensors.size(), pose));
  const SceneMotion empty_room = [](double) { return DepthScene{}; };
  return {spec,
          item,
          generated_motion(Person{}, Activity::walking),
          sensors,
          0.5,
          {default_body_tracker()},
          SyntheticDepth{empty_room, {}, {}}};
}

TEST(NetworkLink, DeliversOverTlsWhatADirectRecordingWouldHold) {
  SyntheticSource direct = two_virtual_sensors(), sent = two_virtual_sensors();
  const Received expected = receive_all(direct);
  const TestKeys keys;
  NetworkSource network(listen_options(keys));
  RunningAgent agent(sent, agent_options("k1"), connect_as(keys, "k1", network.port()));
  network.wait_for_agents(1, kGenerous);
  ASSERT_EQ(network.header().sensors.size(), 2u);
  EXPECT_TRUE(network.header().simulated);
  for (std::size_t s = 0; s < 2; ++s) {
    const SensorDescription &a = network.header().sensors[s], &b = direct.header().sensors[s];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.serial, b.serial);
    EXPECT_EQ(a.intrinsics.k2, b.intrinsics.k2);
    EXPECT_EQ(a.nominal_rate_hz, b.nominal_rate_hz);
    EXPECT_EQ(a.latency_ns, b.latency_ns);
    EXPECT_TRUE(a.has_depth);
  }
  const Received received = receive_all(network);
  ASSERT_GT(expected.frames.size(), 50u);
  ASSERT_EQ(received.frames.size(), expected.frames.size());
  for (std::size_t i = 0; i < expected.frames.size(); ++i) {
    ASSERT_EQ(received.frames[i].sensor, expected.frames[i].sensor);
    ASSERT_TRUE(same_frame(received.frames[i], expected.frames[i])) << i;
  }
  const AgentReport report = agent.report();
  EXPECT_EQ(report.end, AgentEnd::complete);
  EXPECT_EQ(report.status.frames_taken, expected.frames.size());
  EXPECT_EQ(report.status.frames_lost, 0u);
}

TEST(NetworkLink, SeveralAgentsAreOrderedByNameAndEqualSensorNamesAreTold) {
  const TestKeys keys;
  NetworkSource network(listen_options(keys));
  MadeSource first("kinect", made_events(40)), second("kinect", made_events(40)),
      third("own", made_events(40));
  RunningAgent c(third, agent_options("k3"), connect_as(keys, "k3", network.port()));
  RunningAgent b(second, agent_options("k2"), connect_as(keys, "k2", network.port()));
  RunningAgent a(first, agent_options("k1"), connect_as(keys, "k1", network.port()));
  network.wait_for_agents(3, kGenerous);
  std::vector<std::string> names;
  for (const SensorDescription& sensor : network.header().sensors) names.push_back(sensor.name);
  EXPECT_THAT(names, testing::ElementsAre("k1", "k2", "own"));
  Received of_sensor[3];
  while (auto event = network.next()) put(of_sensor[event->sensor], std::move(*event));
  for (const Received& received : of_sensor) expect_made_frames(received, 40);
}

TEST(NetworkLink, TooFewAgentsAreNamedAndNobodyWaitsForEver) {
  const TestKeys keys;
  NetworkSource network(listen_options(keys));
  MadeSource source("kinect", made_events(3));
  RunningAgent agent(source, agent_options("k2"), connect_as(keys, "k2", network.port()));
  try {
    network.wait_for_agents(2, std::chrono::milliseconds(1000));
    FAIL() << "one agent is not two";
  } catch (const InputError& error) {
    EXPECT_THAT(error.problem(), HasSubstr("2 agents were awaited"));
  }
  EXPECT_THROW(network.wait_for_agents(2, kGenerous, [] { return true; }), Interrupted);
}

TEST(NetworkLink, ASourceThatBreaksIsToldAfterEverythingElse) {
  const TestKeys keys;
  NetworkSource network(listen_options(keys));
  MadeSource broken("kinect",
                    [](std::size_t number) -> std::optional<SourceEvent> {
                      if (number == 12) throw InputError("kinect", "is unplugged");
                      return made_event(number, 8);
                    }),
      sound("kinect", made_events(20));
  RunningAgent first(broken, agent_options("k1"), connect_as(keys, "k1", network.port()));
  RunningAgent second(sound, agent_options("k2"), connect_as(keys, "k2", network.port()));
  network.wait_for_agents(2, kGenerous);
  Received received[2];
  try {
    while (auto event = network.next()) put(received[event->sensor], std::move(*event));
    FAIL() << "a broken source is no clean end";
  } catch (const InputError& error) {
    EXPECT_EQ(error.place(), "agent k1");
    EXPECT_THAT(error.problem(), HasSubstr("its source broke: kinect: is unplugged"));
  }
  EXPECT_FALSE(network.next());
  expect_made_frames(received[0], 12);
  expect_made_frames(received[1], 20);
  EXPECT_THAT(received[0].notices, Contains(HasSubstr("the source broke")));
  const AgentReport report = first.report();
  EXPECT_EQ(report.end, AgentEnd::complete);
  EXPECT_THAT(report.source_problem, HasSubstr("unplugged"));
  EXPECT_EQ(second.report().source_problem, "");
}

TEST(NetworkLink, ALinkCutTwentyTimesLosesAndRepeatsNothing) {
  const TestKeys keys;
  NetworkSource network(listen_options(keys));
  const RandomStream random{11, Purpose::test, 0};
  std::vector<std::size_t> cuts;
  for (std::uint32_t i = 0; i < 60; ++i)
    cuts.push_back(static_cast<std::size_t>(random.uniform(i, 2e3, 6e4)));
  CuttingProxy proxy(network.port(), cuts);
  MadeSource source("kinect", made_events(2400));
  AgentOptions options = agent_options("k1");
  options.ring_bytes = 1 << 20;
  RunningAgent agent(source, options, connect_as(keys, "k1", proxy.port()));
  network.wait_for_agents(1, kGenerous);
  const Received received = receive_all(network);
  EXPECT_GE(proxy.cuts(), 20u);
  expect_made_frames(received, 2400);
  EXPECT_THAT(received.notices, Contains(HasSubstr("agent k1: connection lost")));
  EXPECT_THAT(received.notices, Contains(HasSubstr("nothing lost")));
  const AgentReport report = agent.report();
  EXPECT_EQ(report.end, AgentEnd::complete);
  EXPECT_EQ(report.status.frames_lost, 0u);
  EXPECT_GT(report.status.reconnections, 3u);
}

TEST(NetworkLink, APeerThatFallsSilentIsLeftAndFoundAgain) {
  const TestKeys keys;
  ListenOptions listen = listen_options(keys);
  listen.silence_limit = std::chrono::milliseconds(2500);
  NetworkSource network(listen);
  CuttingProxy proxy(network.port(), {});
  std::atomic<bool> go_on{false};
  MadeSource source("kinect", [&](std::size_t number) -> std::optional<SourceEvent> {
    while (number == 100 && !go_on) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return made_events(200)(number);
  });
  AgentOptions options = agent_options("k1");
  options.silence_limit = std::chrono::milliseconds(2500);
  RunningAgent agent(source, options, connect_as(keys, "k1", proxy.port()));
  network.wait_for_agents(1, kGenerous);
  Received received;
  while (received.frames.size() < 100) put(received, *network.next());
  proxy.stall(true);
  go_on = true;
  const auto lost = [&] { return !received.notices.empty(); };
  while (!lost()) put(received, *network.next());
  proxy.cut_all();
  proxy.stall(false);
  while (auto event = network.next()) put(received, std::move(*event));
  expect_made_frames(received, 200);
  EXPECT_THAT(received.notices.front(), HasSubstr("connection lost"));
}

TEST(NetworkLink, ClockExchangesAreInOrderAndGoOnDuringTheRecording) {
  const TestKeys keys;
  ListenOptions listen = listen_options(keys);
  listen.exchange_period = std::chrono::milliseconds(10);
  NetworkSource network(listen);
  std::atomic<bool> enough{false};
  MadeSource source("kinect", [&](std::size_t number) -> std::optional<SourceEvent> {
    if (enough) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return made_event(number, 1'000'000);
  });
  RunningAgent agent(source, agent_options("k1"), connect_as(keys, "k1", network.port()));
  network.wait_for_agents(1, kGenerous);
  std::vector<ClockExchange> exchanges;
  while (auto event = network.next()) {
    if (const auto* exchange = std::get_if<ClockExchange>(&event->data)) exchanges.push_back(*exchange);
    enough = exchanges.size() >= 12;
  }
  ASSERT_GE(exchanges.size(), 12u);
  std::int64_t before_ns = 0;
  for (const ClockExchange& e : exchanges) {
    EXPECT_LE(before_ns, e.t1_ns);
    EXPECT_LE(e.t1_ns, e.t2_ns);  // both ends are this machine
    EXPECT_LE(e.t2_ns, e.t3_ns);
    EXPECT_LE(e.t3_ns, e.t4_ns);
    before_ns = e.t4_ns;
  }
}

TEST(NetworkLink, StoppingTheRecordingMachineEndsTheAgent) {
  const TestKeys keys;
  auto network = std::make_unique<NetworkSource>(listen_options(keys));
  MadeSource source("kinect", made_events(100'000'000, 1'000'000), false);
  RunningAgent agent(source, agent_options("k1"), connect_as(keys, "k1", network->port()));
  network->wait_for_agents(1, kGenerous);
  Received received;
  while (received.frames.size() < 50) put(received, *network->next());
  network->stop();
  network->stop();
  while (auto event = network->next()) put(received, std::move(*event));
  network.reset();
  const AgentReport report = agent.report();
  EXPECT_EQ(report.end, AgentEnd::complete);
  EXPECT_EQ(report.status.frames_lost, 0u);
  EXPECT_EQ(received.frames.size(), report.status.frames_taken);  // also what it held when it was stopped
}

TEST(NetworkLink, WhatAnAgentCannotSendInTimeAfterTheStopIsCountedAndNamed) {
  const TestKeys keys;
  ListenOptions listen = listen_options(keys);
  listen.queue_bytes = 20'000;
  listen.drain_limit = std::chrono::milliseconds(100);
  NetworkSource network(listen);
  MadeSource source("kinect", made_events(400));
  RunningAgent agent(source, agent_options("k1"), connect_as(keys, "k1", network.port()));
  network.wait_for_agents(1, kGenerous);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // nobody takes what comes
  network.stop();
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  Received received;
  std::string problem = "no error";
  try {
    while (auto event = network.next()) put(received, std::move(*event));
  } catch (const InputError& error) {
    problem = error.what();
  }
  EXPECT_THAT(problem, HasSubstr("agent k1: has not sent all it held"));
  EXPECT_LT(received.frames.size(), 400u);
  ASSERT_FALSE(received.drops.empty());
  EXPECT_GT(received.drops.back().in_queue, 0);
  EXPECT_THAT(received.notices, testing::Contains(HasSubstr("that it still held are lost")));
}

TEST(NetworkLink, StoppingTheAgentSendsWhatItHasAndEndsTheRecording) {
  const TestKeys keys;
  NetworkSource network(listen_options(keys));
  MadeSource source("kinect", made_events(100'000'000, 1'000'000));
  RunningAgent agent(source, agent_options("k1"), connect_as(keys, "k1", network.port()));
  network.wait_for_agents(1, kGenerous);
  Received received;
  while (received.frames.size() < 50) put(received, *network.next());
  agent.link().stop();
  while (auto event = network.next()) put(received, std::move(*event));
  const AgentReport report = agent.report();
  EXPECT_EQ(report.end, AgentEnd::complete);
  EXPECT_EQ(received.frames.size(), report.status.frames_taken);
  expect_made_frames(received, received.frames.size(), 1'000'000);
}

TEST(NetworkLink, AnAgentStartedAnewGoesOnInTheSameRecording) {
  const TestKeys keys;
  NetworkSource network(listen_options(keys));
  MadeSource first("kinect", made_events(100'000'000, 1'000'000)), second("kinect", made_events(30, 8));
  CuttingProxy proxy(network.port(), {});
  AgentOptions options = agent_options("k1");
  options.farewell_limit = std::chrono::milliseconds(1);
  auto agent = std::make_unique<RunningAgent>(first, options, connect_as(keys, "k1", proxy.port()));
  network.wait_for_agents(1, kGenerous);
  Received received;
  while (received.frames.size() < 20) put(received, *network.next());
  proxy.refuse(true);
  proxy.cut_all();
  // until the recorder has seen that it is cut: what the agent says from here on does not arrive
  while (received.notices.empty()) put(received, *network.next());
  agent->link().stop();
  EXPECT_EQ(agent->report().end, AgentEnd::unacknowledged);
  options.incarnation = 2;
  received = {};
  std::vector<std::string> notices;
  RunningAgent anew(second, options, connect_as(keys, "k1", network.port()));
  while (auto event = network.next()) {
    if (const auto* bodies = std::get_if<BodyFrame>(&event->data); bodies && bodies->stamp.sequence == 0)
      received = {};
    put(received, std::move(*event));
    if (!received.notices.empty()) notices.push_back(received.notices.back());
  }
  expect_made_frames(received, 30);
  EXPECT_THAT(notices, Contains(HasSubstr("started anew")));
}

// An agent's way to the recording machine: through a proxy, until that machine is replaced by another.
struct ReplaceableServer {
  TestKeys keys;
  NetworkSource first{listen_options(keys)};
  CuttingProxy proxy{first.port(), {}};
  NetworkSource second{listen_options(keys)};
  std::atomic<std::uint16_t> port{proxy.port()};

  ConnectLink connect() {
    return [this] { return connect_as(keys, "k1", port)(); };
  }
  void replace() {
    port = second.port();
    proxy.refuse(true);
    proxy.cut_all();
  }
};

TEST(NetworkLink, AnAgentWhoseRecordingIsGoneStartsOverInTheNextOne) {
  ReplaceableServer server;
  std::atomic<std::size_t> made{0};
  std::atomic<bool> enough{false};
  MadeSource source(
      "kinect",
      [&](std::size_t number) -> std::optional<SourceEvent> {
        if (enough) return std::nullopt;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        made = number;
        return made_event(number, 1'000'000);
      },
      true);
  RunningAgent agent(source, agent_options("k1"), server.connect());
  server.first.wait_for_agents(1, kGenerous);
  Received received;
  while (received.frames.size() < 20) put(received, *server.first.next());
  server.replace();
  while (agent.link().status().recordings_abandoned == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const std::size_t made_before = made;
  server.second.wait_for_agents(1, kGenerous);
  Received anew;
  while (auto event = server.second.next()) {
    put(anew, std::move(*event));
    enough = anew.frames.size() >= 20;
  }
  const auto first = static_cast<std::size_t>(stamp_of(anew.frames.at(0)).sequence);
  EXPECT_GE(first, made_before);
  for (std::size_t i = 0; i < anew.frames.size(); ++i)
    ASSERT_TRUE(same_frame(anew.frames[i], made_event(first + i, 1'000'000))) << i;
  EXPECT_TRUE(anew.drops.empty());
  const AgentReport report = agent.report();
  EXPECT_EQ(report.end, AgentEnd::complete);
  EXPECT_EQ(report.status.recordings_abandoned, 1u);
}

TEST(NetworkLink, AnAgentWhoseSourceHasEndedDoesNotTakePartInTheNextRecording) {
  ReplaceableServer server;
  std::atomic<bool> stalled{false};
  MadeSource source("kinect", [&](std::size_t number) -> std::optional<SourceEvent> {
    while (!stalled) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return made_events(20)(number);
  });
  RunningAgent agent(source, agent_options("k1"), server.connect());
  server.first.wait_for_agents(1, kGenerous);
  while (!agent.link().status().recording) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  server.proxy.stall(true);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  stalled = true;
  while (agent.link().status().frames_taken < 20) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  server.replace();
  const AgentReport report = agent.report();
  EXPECT_EQ(report.end, AgentEnd::abandoned);
  EXPECT_EQ(report.status.frames_lost, 20u);
  EXPECT_THROW(server.second.wait_for_agents(1, std::chrono::milliseconds(300)), InputError);
}

}  // namespace
}  // namespace trilat
