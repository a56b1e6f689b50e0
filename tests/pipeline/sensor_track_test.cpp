// SPDX-License-Identifier: MIT
// The choice of a sensor's frame for an instant.
#include "pipeline/accuracy/take/sensor_track.h"

#include <gtest/gtest.h>

namespace trilat {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr Duration kGap{110 * kMs}, kLate{33 * kMs};

// Frames 33 ms apart with one body each, whose head is as many metres before the sensor as the frame's
// number; they arrive so many milliseconds after their exposure.
struct Track {
  std::vector<IdentifiedBody> bodies;
  std::vector<SensorFrame> frames;

  explicit Track(const std::vector<std::int64_t>& delays_ms) : bodies(delays_ms.size()) {
    for (std::size_t f = 0; f < delays_ms.size(); ++f) {
      const auto head = static_cast<std::size_t>(Joint::head);
      bodies[f].body.joint_in_sensor_m[head] = {0.0F, 0.0F, static_cast<float>(f + 1)};
      bodies[f].body.state[head] = TrackingState::tracked;
      const HostTime exposed{static_cast<std::int64_t>(f) * 33 * kMs};
      frames.push_back({exposed, exposed + Duration{delays_ms[f] * kMs}, std::span(&bodies[f], 1)});
    }
  }
  // Number of the frame, from 1, that `t_ms` gets; 0 where there is none.
  float newest(std::int64_t t_ms) const { return depth_of(newest_body(frames, {t_ms * kMs}, kGap, kLate)); }
  float between(std::int64_t t_ms) const { return depth_of(body_at(frames, {t_ms * kMs}, kGap)); }
  static float depth_of(const ObservedBody& body) {
    return body.has(static_cast<std::size_t>(Joint::head))
               ? body.joint_in_sensor_m[static_cast<std::size_t>(Joint::head)].z()
               : 0.0F;
  }
};

TEST(SensorTrack, TheNewestFrameIsThatWhichHadArrivedAndIsHeld) {
  const Track track({20, 20, 20});
  EXPECT_EQ(track.newest(19), 0.0F);
  EXPECT_EQ(track.newest(20), 1.0F);
  EXPECT_EQ(track.newest(52), 1.0F);
  EXPECT_EQ(track.newest(53), 2.0F);
  EXPECT_EQ(track.newest(66 + 110), 3.0F);
  EXPECT_EQ(track.newest(66 + 111), 0.0F);
}

TEST(SensorTrack, AFrameThatComesTooLateIsDroppedAndTheOneBeforeHeld) {
  const Track track({10, 34, 10});
  EXPECT_EQ(track.newest(75), 1.0F);
  EXPECT_EQ(track.newest(76), 3.0F);
  EXPECT_EQ(Track({10, 33, 10}).newest(70), 2.0F);
}

TEST(SensorTrack, FramesOutOfTheirOrderGiveTheNewestExposure) {
  const Track track({30, 2, 20});
  EXPECT_EQ(track.newest(36), 2.0F);
  EXPECT_EQ(track.newest(29), 0.0F);
}

TEST(SensorTrack, BetweenTwoFramesAJointIsInterpolated) {
  const Track track({20, 20, 20});
  EXPECT_FLOAT_EQ(track.between(33), 2.0F);
  EXPECT_NEAR(track.between(50), 2.0F + 17.0F / 33.0F, 1e-5);
  EXPECT_EQ(track.between(67), 0.0F);
}

}  // namespace
}  // namespace trilat
