// SPDX-License-Identifier: MIT
#include "recorders/open_source.h"

#include <stdexcept>

#include <gmock/gmock.h>

#include "recorders/test_source.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

std::vector<SourceEvent> all_of(FrameSource& source) {
  std::vector<SourceEvent> events;
  while (auto event = source.next()) events.push_back(std::move(*event));
  return events;
}

TEST(OpenSource, WrongTextsSayWhatWouldBeRight) {
  const auto message = [](const std::string& text) { return message_of([&] { open_source(text); }); };
  EXPECT_THAT(message("azure:1"), HasSubstr("no source \"azure\"; there is synthetic:4"));
  EXPECT_THAT(message("kinect"), HasSubstr("trilat-agent.exe"));
  EXPECT_THAT(message("synthetic:0"), HasSubstr("the number of sensors must be a number from 1 to 16"));
  EXPECT_THAT(message("synthetic:4,colour=yes"), HasSubstr("no setting \"colour\"; it has seed, depth"));
  EXPECT_THAT(message("synthetic:4,depth"), HasSubstr("settings of a source are KEY=VALUE"));
  EXPECT_THAT(message("synthetic:4,depth=no,depth=yes"), HasSubstr("\"depth\" is set twice"));
  EXPECT_THAT(message("synthetic:4,depth=all"), HasSubstr("depth must be yes, no or wand, is \"all\""));
  EXPECT_THAT(message("synthetic:4,drop=0.1"), HasSubstr("no setting \"drop\""));
}

// The arrivals are those of this machine's clock; a second of them takes a second.
TEST(OpenSource, ALiveSensorIsPacedAndStampedWithThisMachinesClock) {
  const std::int64_t before = host_now_ns();
  const auto events = all_of(*open_source("synthetic:2,depth=no,duration=1"));
  const std::int64_t after = host_now_ns();
  EXPECT_GT(after - before, 900'000'000);
  std::size_t frames = 0;
  for (const SourceEvent& event : events)
    if (const auto* frame = std::get_if<BodyFrame>(&event.data)) {
      ++frames;
      EXPECT_GT(frame->stamp.arrival_ns, before);
      EXPECT_LT(frame->stamp.arrival_ns, after);
    }
  EXPECT_EQ(frames, 60u);
}

// A source that gives the events of a list and then, with `breaks`, throws.
class ListSource : public FrameSource {
 public:
  ListSource(std::size_t sensors, std::vector<SourceEvent> events, bool breaks = false)
      : events_(std::move(events)), breaks_(breaks) {
    header_.sensors.resize(sensors);
  }
  const SessionHeader& header() const override { return header_; }
  std::optional<SourceEvent> next() override {
    if (next_ < events_.size()) return events_[next_++];
    if (breaks_) throw std::runtime_error("broken");
    return std::nullopt;
  }

 private:
  SessionHeader header_;
  std::vector<SourceEvent> events_;
  std::size_t next_ = 0;
  bool breaks_;
};

SourceEvent bodies_at(std::size_t sensor, std::int64_t sequence, std::int64_t arrival_ns) {
  BodyFrame frame;
  frame.stamp = {sequence, 0, arrival_ns};
  return {sensor, frame};
}
SourceEvent depth_at(std::size_t sensor, std::int64_t sequence, std::int64_t arrival_ns) {
  return {sensor, DepthFrame{{sequence, 0, arrival_ns}, {}}};
}

// Sensor and arrival, less the start, of what a live source gives as fast as it is taken.
std::vector<std::pair<std::size_t, std::int64_t>> arrivals_of(std::vector<SourceEvent> events,
                                                              bool one_clock) {
  LiveSource source(std::make_unique<ListSource>(2, std::move(events)),
                    {.speed = 0.0, .one_clock = one_clock, .origin_ns = 1'000});
  const std::int64_t start_ns = source.start();
  std::vector<std::pair<std::size_t, std::int64_t>> arrivals;
  for (const SourceEvent& event : all_of(source)) {
    std::int64_t at_ns = 0;
    if (const auto* frame = std::get_if<BodyFrame>(&event.data)) at_ns = frame->stamp.arrival_ns;
    if (const auto* frame = std::get_if<DepthFrame>(&event.data)) at_ns = frame->stamp.arrival_ns;
    if (const auto* exchange = std::get_if<ClockExchange>(&event.data)) {
      at_ns = exchange->t1_ns;
      EXPECT_EQ(exchange->t2_ns, at_ns + 1);
      EXPECT_EQ(exchange->t3_ns, at_ns + 2);
      EXPECT_EQ(exchange->t4_ns, at_ns + 3);
    }
    if (const auto* count = std::get_if<DropCount>(&event.data)) at_ns = count->host_ns;
    arrivals.emplace_back(event.sensor, at_ns - start_ns);
  }
  return arrivals;
}

TEST(LiveSource, EventsComeInTheOrderOfTheirTimesMovedToNow) {
  const std::vector<SourceEvent> events{bodies_at(0, 0, 5'000),
                                        depth_at(0, 0, 7'000),
                                        bodies_at(1, 0, 4'000),
                                        {1, ClockExchange{5'997, 5'998, 5'999, 6'000}},
                                        {0, DropCount{3'000, 1, 2}}};
  // what says no time is due at once; an exchange when it was answered
  EXPECT_THAT(arrivals_of(events, true),
              testing::ElementsAre(testing::Pair(0, 2'000), testing::Pair(1, 3'000), testing::Pair(0, 4'000),
                                   testing::Pair(1, 4'997), testing::Pair(0, 6'000)));
  // on clocks of their own the first frame of each sensor is due at the start
  EXPECT_THAT(arrivals_of({bodies_at(0, 0, 90'000), bodies_at(0, 1, 95'000), bodies_at(1, 0, 5'000),
                           bodies_at(1, 1, 9'000)},
                          false),
              testing::ElementsAre(testing::Pair(0, 89'000), testing::Pair(1, 4'000), testing::Pair(1, 8'000),
                                   testing::Pair(0, 94'000)));
}

// Three frames are due at the start and a fourth after 0.6 s; the test takes none for 0.3 s. The source
// counts a frame once where it loses both its bodies and its depth.
TEST(LiveSource, WhatNobodyTakesInTimeIsLostAndCountedOnce) {
  LiveSource source(std::make_unique<ListSource>(
                        2, std::vector<SourceEvent>{bodies_at(0, 0, 0), depth_at(0, 0, 0), bodies_at(0, 1, 0),
                                                    bodies_at(1, 0, 0), bodies_at(0, 2, 600'000'000)}),
                    {.stamp_arrivals = true, .one_clock = true});
  const std::int64_t start_ns = source.start();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  std::vector<std::string> given;
  for (const SourceEvent& event : all_of(source)) {
    if (const auto* count = std::get_if<DropCount>(&event.data)) {
      given.push_back("lost " + std::to_string(event.sensor) + ": " + std::to_string(count->at_source));
      EXPECT_EQ(count->in_queue, 0);
      EXPECT_GT(count->host_ns, start_ns + 200'000'000);
    } else {
      const FrameStamp& stamp = std::get<BodyFrame>(event.data).stamp;
      given.push_back("frame " + std::to_string(stamp.sequence));
      EXPECT_GE(stamp.arrival_ns, start_ns + 600'000'000);
    }
  }
  EXPECT_THAT(given, testing::ElementsAre("lost 0: 1", "lost 0: 1", "lost 0: 2", "lost 1: 1", "frame 2"));
}

TEST(LiveSource, StoppedItGivesNothingMoreAndWithItsOwnStampsNoExchange) {
  LiveSource stamped(std::make_unique<ListSource>(
                         1, std::vector<SourceEvent>{{0, ClockExchange{1, 2, 3, 4}}, bodies_at(0, 0, 0)}),
                     {.stamp_arrivals = true, .one_clock = true});
  EXPECT_TRUE(stamped.live());
  const auto events = all_of(stamped);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<BodyFrame>(events[0].data));
  LiveSource source(
      std::make_unique<ListSource>(1, std::vector<SourceEvent>{bodies_at(0, 0, 60'000'000'000)}),
      {.one_clock = true});
  std::thread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    source.stop();
  });
  EXPECT_FALSE(source.next());  // which waited for the minute's frame
  stopper.join();
  EXPECT_FALSE(source.next());
  EXPECT_FALSE(
      LiveSource(std::make_unique<ListSource>(1, std::vector<SourceEvent>{}), {.speed = 0.0}).live());
}

TEST(PrefetchSource, GivesAllThatWasMadeBeforeAnError) {
  std::vector<SourceEvent> events;
  for (std::int64_t k = 0; k < 20; ++k) events.push_back(bodies_at(0, k, k));
  PrefetchSource source(std::make_unique<ListSource>(1, events, true), 3);
  for (std::int64_t k = 0; k < 20; ++k) {
    const auto event = source.next();
    ASSERT_TRUE(event);
    EXPECT_EQ(std::get<BodyFrame>(event->data).stamp.sequence, k);
  }
  EXPECT_THROW(source.next(), std::runtime_error);
  EXPECT_FALSE(source.next());
  PrefetchSource stopped(std::make_unique<ListSource>(1, events), 3);
  stopped.stop();
  EXPECT_FALSE(stopped.next());
}

TEST(TestSource, MakesThirtyFramesASecondOfASlopeAndAPerson) {
  TestSource source(0.19);
  EXPECT_TRUE(source.header().simulated);
  const std::int64_t before_ns = host_now_ns();
  const auto events = all_of(source);
  ASSERT_EQ(events.size(), 12u);  // 0.19 s begin six frames
  EXPECT_GT(host_now_ns() - before_ns, 5 * 33'333'300ll);
  for (std::size_t k = 0; k < events.size(); ++k) {
    const auto frame = static_cast<std::int64_t>(k / 2);
    const auto* depth = std::get_if<DepthFrame>(&events[k].data);
    const auto* bodies = std::get_if<BodyFrame>(&events[k].data);
    ASSERT_TRUE(k % 2 == 0 ? depth != nullptr : bodies != nullptr);
    const FrameStamp& stamp = depth ? depth->stamp : bodies->stamp;
    EXPECT_EQ(stamp.sequence, frame);
    EXPECT_EQ(stamp.device_ticks, frame * 333'333);
    EXPECT_GE(stamp.arrival_ns, before_ns + frame * 33'333'300);
    if (depth) {
      ASSERT_EQ(depth->depth_mm.size(), kDepthPixels);
      EXPECT_EQ(depth->depth_mm[0], 1000 + 4 * frame);
      EXPECT_EQ(depth->depth_mm[511], 1000 + 4 * ((511 + frame) % 512));
    } else {
      ASSERT_EQ(bodies->bodies.size(), 1u);
      const auto at = [&](Joint joint) {
        return bodies->bodies[0].position_m[static_cast<std::size_t>(joint)];
      };
      EXPECT_NEAR(at(Joint::spine_base)[0], 0.2 * std::sin(0.1 * static_cast<double>(frame)), 1e-6);
      EXPECT_NEAR(at(Joint::head)[1] - at(Joint::foot_left)[1], 1.65, 1e-6);
      EXPECT_GT(at(Joint::wrist_left)[0], at(Joint::wrist_right)[0]);  // x to the sensor's left
    }
  }
}

TEST(SyntheticRequest, HasWhatItsTextSays) {
  EXPECT_FALSE(synthetic_request("kinect"));
  const auto plain = synthetic_request("synthetic");
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->sensors, 4u);
  EXPECT_EQ(plain->depth, SyntheticRequest::Depth::walker);
  EXPECT_TRUE(plain->live.stamp_arrivals);
  const auto set = synthetic_request("synthetic:6,seed=9,depth=wand,duration=2.5,speed=4");
  EXPECT_EQ(set->sensors, 6u);
  EXPECT_EQ(set->seed, 9u);
  EXPECT_EQ(set->depth, SyntheticRequest::Depth::wand);
  EXPECT_EQ(set->duration_s, 2.5);
  EXPECT_EQ(set->live.speed, 4.0);
  EXPECT_FALSE(set->live.stamp_arrivals);
  EXPECT_EQ(synthetic_request("synthetic:1,speed=max")->live.speed, 0.0);
  const SyntheticSetup setup = setup_of(*set);
  ASSERT_EQ(setup.sensors.size(), 6u);
  EXPECT_TRUE(setup.wand);
  const auto height_m = [&](std::size_t s) {
    return setup.sensors[s].pose.world_from_sensor.translation_m[1];
  };
  EXPECT_EQ(height_m(4), height_m(0));  // heights come again
  EXPECT_EQ(height_m(5), height_m(1));
  EXPECT_FALSE(setup_of(*plain).wand);
  EXPECT_THAT(message_of([] { open_source("synthetic:1,speed=2", "--source", SourceUse::agent); }),
              HasSubstr("real speed only"));
}

}  // namespace
}  // namespace trilat
