// SPDX-License-Identifier: MIT
#include "recorders/freenect2/depth_feed.h"

#include <limits>
#include <thread>

#include <gtest/gtest.h>

namespace trilat {
namespace {

using namespace std::chrono_literals;

const std::vector<float> kFlat(kDepthPixels, 1234.6f);

DecodedDepth decoded(std::uint32_t sequence, std::uint32_t timestamp) { return {kFlat, timestamp, sequence}; }

FrameStamp popped_stamp(DepthFeed& feed) {
  const auto event = feed.pop(0ms);
  if (!event || !std::holds_alternative<DepthFrame>(event->data)) {
    ADD_FAILURE() << "no frame";
    return {};
  }
  return std::get<DepthFrame>(event->data).stamp;
}

TEST(DepthFeed, RoundsMillimetresAndMakesWhatIsInvalidZero) {
  EXPECT_EQ(depth_mm_of(1234.4f), 1234);
  EXPECT_EQ(depth_mm_of(1234.6f), 1235);
  EXPECT_EQ(depth_mm_of(0.0f), 0);
  EXPECT_EQ(depth_mm_of(-5.0f), 0);
  EXPECT_EQ(depth_mm_of(70000.0f), 0);
  EXPECT_EQ(depth_mm_of(std::numeric_limits<float>::quiet_NaN()), 0);
  EXPECT_EQ(depth_mm_of(std::numeric_limits<float>::infinity()), 0);
}

TEST(DepthFeed, HandsFramesOnInOrder) {
  DepthFeed feed(4);
  feed.push(decoded(7, 1000), 50);
  feed.push(decoded(8, 1267), 51);
  const auto event = feed.pop(0ms);
  ASSERT_TRUE(event);
  const auto& frame = std::get<DepthFrame>(event->data);
  EXPECT_EQ(frame.depth_mm, std::vector<std::uint16_t>(kDepthPixels, 1235));
  EXPECT_EQ(frame.stamp.sequence, 7);
  EXPECT_EQ(frame.stamp.arrival_ns, 50);
  EXPECT_EQ(popped_stamp(feed).device_ticks, 1267);
  EXPECT_FALSE(feed.pop(0ms));
}

TEST(DepthFeed, CountsWhatHasNoRoomOrIsDamaged) {
  DepthFeed feed(1);
  feed.push(decoded(1, 0), 0);
  feed.push(decoded(2, 267), 0);
  DecodedDepth torn = decoded(3, 533);
  torn.depth_mm = torn.depth_mm.first(10);
  feed.push(torn, 99);
  const auto count = feed.pop(0ms);
  ASSERT_TRUE(count);
  EXPECT_EQ(std::get<DropCount>(count->data).at_source, 2);
  EXPECT_EQ(std::get<DropCount>(count->data).host_ns, 99);
  EXPECT_EQ(popped_stamp(feed).sequence, 1);
  EXPECT_FALSE(feed.pop(0ms));
}

TEST(DepthFeed, TimesGoOnWhereTheCountersOverflow) {
  DepthFeed feed(4);
  feed.push(decoded(0xffffffffu, 0xffffffffu - 99), 0);
  feed.push(decoded(0, 167), 0);
  const FrameStamp before = popped_stamp(feed), after = popped_stamp(feed);
  EXPECT_EQ(after.sequence - before.sequence, 1);
  EXPECT_EQ(after.device_ticks - before.device_ticks, 267);
}

// Frame 2 is handed over when frame 4 begins, frame 3 having been lost: its stamp is a period too late.
TEST(DepthFeed, AStampOfAFrameBeforeALostOneIsSetRight) {
  DepthFeed feed(8);
  feed.push(decoded(1, 1000), 0);
  feed.push(decoded(2, 1534), 0);
  feed.push(decoded(4, 1800), 0);
  EXPECT_EQ(popped_stamp(feed).device_ticks, 1000);
  EXPECT_EQ(popped_stamp(feed).device_ticks, 1267);
  EXPECT_EQ(popped_stamp(feed).device_ticks, 1800);
}

TEST(DepthFeed, WhatOneThreadPushesAnotherPopsOrIsToldLost) {
  constexpr int kFrames = 100;
  DepthFeed feed(4);
  std::thread driver([&] {
    for (int i = 0; i < kFrames; ++i) {
      const auto n = static_cast<std::uint32_t>(i);
      feed.push(decoded(n, n * 267), i);
    }
  });
  int popped = 0;
  std::int64_t lost = 0;
  while (popped + lost < kFrames) {
    const auto event = feed.pop(10s);
    ASSERT_TRUE(event);
    if (std::holds_alternative<DepthFrame>(event->data))
      ++popped;
    else
      lost = std::get<DropCount>(event->data).at_source;
  }
  driver.join();
  EXPECT_EQ(popped + lost, kFrames);
}

TEST(DepthFeed, StopEndsTheWaitOfAnotherThread) {
  DepthFeed feed(1);
  std::thread stopper([&] { feed.stop(); });
  EXPECT_FALSE(feed.pop(60s));
  stopper.join();
  feed.push(decoded(1, 0), 0);
  EXPECT_FALSE(feed.pop(0ms));
}

}  // namespace
}  // namespace trilat
