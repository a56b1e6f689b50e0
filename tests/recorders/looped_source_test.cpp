// SPDX-License-Identifier: MIT
#include "recorders/looped_source.h"

#include <gtest/gtest.h>

#include "recorders/open_source.h"

namespace trilat {
namespace {

TEST(LoopedSource, RepeatsFramesWithStampsThatGoOn) {
  const auto taken = take_all(*open_source("synthetic:2,duration=0.2,drop=0,speed=max"));
  ASSERT_EQ(taken.size(), 2u);
  ASSERT_EQ(taken[0].depth.size(), taken[0].bodies.size());
  const std::size_t frames = taken[0].depth.size();
  std::vector<std::shared_ptr<const SensorFrames>> sensors;
  for (const SensorFrames& s : taken) sensors.push_back(std::make_shared<const SensorFrames>(s));
  LoopedSource source(sensors, 300.0, 0.1);
  std::vector<std::int64_t> next(2, 0);
  std::int64_t last_arrival_ns = 0;
  while (const auto event = source.next()) {
    const auto* depth = std::get_if<DepthFrame>(&event->data);
    if (!depth) continue;
    EXPECT_EQ(depth->stamp.sequence, next[event->sensor]++);
    EXPECT_EQ(depth->stamp.device_ticks, depth->stamp.sequence * 100'000 / 3);
    EXPECT_GE(depth->stamp.arrival_ns, last_arrival_ns);
    last_arrival_ns = depth->stamp.arrival_ns;
    EXPECT_EQ(depth->depth_mm,
              taken[event->sensor].depth[static_cast<std::size_t>(depth->stamp.sequence) % frames].depth_mm);
  }
  EXPECT_EQ(next, (std::vector<std::int64_t>{30, 30}));
}

}  // namespace
}  // namespace trilat
