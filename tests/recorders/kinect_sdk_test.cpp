// SPDX-License-Identifier: MIT
#include <cstring>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "recorders/kinect_sdk/kinect_source.h"
#include "tests/recorders/fake_kinect.h"

namespace trilat {
namespace {

using namespace std::chrono_literals;
using kinect::fake::Desk;
using kinect::fake::Exposure;
using testing::HasSubstr;

constexpr std::int64_t kPeriod = 333'333;
constexpr KinectOptions kQuick{50ms, 20ms};

Exposure both(std::int64_t ticks, std::uint16_t depth_mm = 1000) { return {ticks, ticks, depth_mm}; }

// The first exposure wakes the source and is not recorded.
Desk desk_with(std::initializer_list<Exposure> exposures) {
  Desk desk;
  desk.exposures = exposures;
  desk.exposures.push_front(both(1000));
  return desk;
}

template <class Frame>
Frame take(KinectSource& source) {
  auto event = source.next();
  if (!event || !std::holds_alternative<Frame>(event->data)) {
    ADD_FAILURE() << "another kind of event than expected";
    return {};
  }
  return std::get<Frame>(std::move(event->data));
}

std::string problem_of(Desk& desk) {
  try {
    const KinectSource source(kinect::fake::runtime_of(desk), kQuick);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no problem";
}

// Index of a virtual function in its table; the Itanium ABI stores one more than the offset.
template <class Function>
std::size_t slot_of(Function function) {
  std::size_t bits = 0;
  std::memcpy(&bits, &function, sizeof bits);
  return (bits - 1) / sizeof(void*);
}

TEST(KinectSdk, FunctionsStandWhereTheSdkHasThem) {
  using namespace kinect;
  EXPECT_EQ(slot_of(&IKinectSensor::Release), 2u);
  EXPECT_EQ(slot_of(&IKinectSensor::Open), 6u);
  EXPECT_EQ(slot_of(&IKinectSensor::Close), 7u);
  EXPECT_EQ(slot_of(&IKinectSensor::get_IsAvailable), 9u);
  EXPECT_EQ(slot_of(&IKinectSensor::OpenMultiSourceFrameReader), 17u);
  EXPECT_EQ(slot_of(&IKinectSensor::get_CoordinateMapper), 18u);
  EXPECT_EQ(slot_of(&IKinectSensor::get_UniqueKinectId), 19u);
  EXPECT_EQ(slot_of(&IMultiSourceFrameReader::GetMultiSourceFrameArrivedEventData), 5u);
  EXPECT_EQ(slot_of(&IMultiSourceFrameArrivedEventArgs::get_FrameReference), 3u);
  EXPECT_EQ(slot_of(&IMultiSourceFrameReference::AcquireFrame), 3u);
  EXPECT_EQ(slot_of(&IMultiSourceFrame::get_DepthFrameReference), 4u);
  EXPECT_EQ(slot_of(&IMultiSourceFrame::get_BodyFrameReference), 5u);
  EXPECT_EQ(slot_of(&IDepthFrame::CopyFrameDataToArray), 3u);
  EXPECT_EQ(slot_of(&IDepthFrame::get_RelativeTime), 6u);
  EXPECT_EQ(slot_of(&IBodyFrame::get_RelativeTime), 5u);
  EXPECT_EQ(slot_of(&IBody::get_HandLeftState), 9u);
  EXPECT_EQ(slot_of(&IBody::get_TrackingId), 14u);
  EXPECT_EQ(slot_of(&IBody::get_IsTracked), 15u);
  EXPECT_EQ(slot_of(&ICoordinateMapper::GetDepthFrameToCameraSpaceTable), 18u);
  EXPECT_EQ(slot_of(&ICoordinateMapper::GetDepthCameraIntrinsics), 19u);
}

TEST(KinectSource, DescribesTheSensorAfterItsFirstFrame) {
  Desk desk = desk_with({});
  const KinectSource source(kinect::fake::runtime_of(desk), kQuick);
  const SensorDescription& sensor = source.header().sensors.at(0);
  EXPECT_EQ(sensor.serial, "012345678947");
  EXPECT_EQ(sensor.source, "kinect-sdk");
  EXPECT_EQ(sensor.tick_ns, 100);
  EXPECT_TRUE(sensor.has_depth);
  EXPECT_EQ(sensor.intrinsics.fy_px, 366.5);
  EXPECT_NEAR(sensor.intrinsics.cy_px, 207.0, 1e-3);
  EXPECT_EQ(sensor.intrinsics.k2, static_cast<double>(-0.27f));
  EXPECT_TRUE(source.live());
}

TEST(KinectSource, TakesThePrincipalPointFromTheTableOfRays) {
  Desk desk = desk_with({});
  desk.rays_right_px = -0.5;
  desk.rays_down_px = 0.5;
  KinectSource source(kinect::fake::runtime_of(desk), kQuick);
  const DepthIntrinsics& in = source.header().sensors.at(0).intrinsics;
  EXPECT_NEAR(in.cx_px, 254.5, 1e-3);
  EXPECT_NEAR(in.cy_px, 207.5, 1e-3);
  EXPECT_THAT(take<SourceNotice>(source).text, HasSubstr("(255.00, 207.00) by (-0.50, 0.50)"));
  EXPECT_EQ(desk.tables_held, 0);
}

TEST(KinectSource, KeepsThePrincipalPointWithoutATableOfRays) {
  Desk desk = desk_with({});
  desk.has_rays = false;
  KinectSource source(kinect::fake::runtime_of(desk), kQuick);
  EXPECT_EQ(source.header().sensors.at(0).intrinsics.cx_px, 255.0);
  desk = desk_with({});
  desk.rays_right_px = 0.5;
  desk.knows_rays = false;
  EXPECT_EQ(KinectSource(kinect::fake::runtime_of(desk), kQuick).header().sensors.at(0).intrinsics.cx_px,
            255.0);
}

TEST(KinectSource, DeliversDepthAndBodiesOfAnExposureWithOneNumber) {
  Exposure exposure = both(1000 + kPeriod, 2345);
  exposure.tracked = true;
  Desk desk = desk_with({exposure});
  KinectSource source(kinect::fake::runtime_of(desk), kQuick);
  const auto depth = take<DepthFrame>(source);
  const auto bodies = take<BodyFrame>(source);
  EXPECT_EQ(depth.depth_mm, std::vector<std::uint16_t>(kDepthPixels, 2345));
  EXPECT_EQ(depth.stamp.device_ticks, 1000 + kPeriod);
  EXPECT_GT(depth.stamp.arrival_ns, 0);
  EXPECT_EQ(depth.stamp.sequence, bodies.stamp.sequence);
  EXPECT_EQ(bodies.floor_plane, (std::array<float, 4>{0.0f, 1.0f, 0.0f, 0.75f}));
  ASSERT_EQ(bodies.bodies.size(), 1u);
  const Body& body = bodies.bodies[0];
  EXPECT_EQ(body.tracking_id, (std::uint64_t{1} << 56) + 2);
  EXPECT_EQ(body.position_m[20], (std::array<float, 3>{2.0f, 20.0f, 2.0f}));
  EXPECT_EQ(body.orientation_xyzw[7], (std::array<float, 4>{0.0f, 0.6f, 0.0f, 0.8f}));
  EXPECT_EQ(body.tracking_state[5], 2);
  EXPECT_EQ(body.hand_state, (std::array<std::uint8_t, 2>{4, 3}));
  EXPECT_EQ(body.hand_confidence, (std::array<std::uint8_t, 2>{1, 0}));
}

TEST(KinectSource, TakesWhatATornExposureHas) {
  Desk desk = desk_with({{std::nullopt, 1000 + kPeriod}, {1000 + 2 * kPeriod, std::nullopt}});
  KinectSource source(kinect::fake::runtime_of(desk), kQuick);
  EXPECT_EQ(take<DropCount>(source).at_source, 1);
  EXPECT_EQ(take<BodyFrame>(source).stamp.sequence, 1);
  EXPECT_EQ(take<DepthFrame>(source).stamp.sequence, 2);
  EXPECT_EQ(take<DropCount>(source).at_source, 2);
}

TEST(KinectSource, AFrameThatIsGoneIsCountedAndLeavesAGapInTheNumbers) {
  Exposure gone = both(1000 + kPeriod);
  gone.pending = true;
  Desk desk = desk_with({gone, both(1000 + 2 * kPeriod)});
  KinectSource source(kinect::fake::runtime_of(desk), kQuick);
  EXPECT_EQ(take<DropCount>(source).at_source, 2);  // of depth and of bodies
  EXPECT_EQ(take<DepthFrame>(source).stamp.sequence, 2);
}

TEST(KinectSource, SaysOnceThatTheSensorIsGoneAndThatItIsBack) {
  Desk desk = desk_with({});
  KinectSource source(kinect::fake::runtime_of(desk), kQuick);
  desk.available = false;
  EXPECT_THAT(take<SourceNotice>(source).text, HasSubstr("unplugged"));
  desk.available = true;
  EXPECT_THAT(take<SourceNotice>(source).text, HasSubstr("delivers no frames"));
  desk.exposures.push_back(both(5));
  EXPECT_THAT(take<SourceNotice>(source).text, HasSubstr("again"));
  EXPECT_EQ(take<DepthFrame>(source).stamp.device_ticks, 5);
}

TEST(KinectSource, RefusesASensorThatDeliversNothing) {
  Desk silent;
  EXPECT_THAT(problem_of(silent), HasSubstr("no frame came"));
  Desk unplugged;
  unplugged.available = false;
  EXPECT_THAT(problem_of(unplugged), HasSubstr("is it plugged"));
  Desk unknowing = desk_with({});
  unknowing.intrinsics_known = false;
  EXPECT_THAT(problem_of(unknowing), HasSubstr("intrinsics"));
}

TEST(KinectSource, EndsWhenStopped) {
  Desk desk = desk_with({});
  KinectSource source(kinect::fake::runtime_of(desk), kQuick);
  source.stop();
  EXPECT_FALSE(source.next());
}

TEST(KinectSource, ReleasesEveryObjectAndMakesSixBodiesOnce) {
  const int before = kinect::fake::live_objects;
  Desk desk = desk_with({both(1000 + kPeriod), both(1000 + 2 * kPeriod), {std::nullopt, std::nullopt}});
  {
    KinectSource source(kinect::fake::runtime_of(desk), kQuick);
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(source.next());
    constexpr int kSensorReaderAndBodies = 8;
    EXPECT_EQ(kinect::fake::live_objects - before, kSensorReaderAndBodies);
  }
  EXPECT_EQ(desk.bodies_made, 6);
  EXPECT_EQ(kinect::fake::live_objects, before);
}

TEST(TickSequence, AClockThatBeginsAnewGoesOnWithTheNextNumber) {
  TickSequence sequence(1, 100);
  EXPECT_EQ(sequence.number_of(0, 1'000'000), 0);
  EXPECT_EQ(sequence.number_of(0, 1'000'304), 3);
  EXPECT_EQ(sequence.number_of(0, 20), 4);
  EXPECT_EQ(sequence.number_of(0, 119), 5);
  EXPECT_EQ(sequence.number_of(0, 900'000'000), 6);
}

}  // namespace
}  // namespace trilat
