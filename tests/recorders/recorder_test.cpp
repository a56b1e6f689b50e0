// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/session/clock/session_clock.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_verify.h"
#include "recorders/capture.h"
#include "recorders/synthetic_source.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

SensorSpec spec_without_drops() {
  SensorSpec spec;
  spec.dropped_share = 0.0;
  return spec;
}

std::vector<SimulatedSensor> rig_of(const SensorSpec& spec, const SimulatedItem& item) {
  std::vector<SimulatedSensor> sensors;
  for (const SensorPose& pose : rig_poses({}, {0.0, 1.0, 0.0}))
    sensors.push_back(draw_sensor(spec, item, sensors.size(), pose));
  return sensors;
}

SyntheticSource source_of(const SensorSpec& spec, const SimulatedItem& item, double duration_s) {
  return {spec,
          item,
          generated_motion(Person{}, Activity::walking),
          rig_of(spec, item),
          duration_s,
          {exact_body_tracker()}};
}

TEST(Recorder, StoresTheFramesOfAllSensorsInTheirOrder) {
  const ScratchFolder folder;
  const SensorSpec spec = spec_without_drops();
  SyntheticSource source = source_of(spec, {1, 0, 0}, 2.0);
  const RecordSummary summary = record(source, folder / "session.h5", {});
  const SessionReader session(folder / "session.h5");
  EXPECT_TRUE(session.complete());
  EXPECT_TRUE(session.header().simulated);
  ASSERT_EQ(session.header().sensors.size(), 4u);
  std::uint64_t stored = 0;
  for (std::size_t s = 0; s < 4; ++s) {
    const std::uint64_t frames = session.counts(s).body_frames;
    stored += frames;
    EXPECT_NEAR(static_cast<double>(frames), 60.0, 1.0);
    EXPECT_EQ(session.counts(s).clock_exchanges, 9u);  // four a second, both ends counted
    const auto stamps = session.stamps(s, FrameStream::bodies, 0, frames);
    for (std::size_t i = 0; i < stamps.size(); ++i)
      EXPECT_EQ(stamps[i].sequence, static_cast<std::int64_t>(i));
    for (std::size_t i = 1; i < stamps.size(); ++i) {
      EXPECT_NEAR(static_cast<double>(stamps[i].device_ticks - stamps[i - 1].device_ticks), 333'333.0, 1.5);
      EXPECT_GT(stamps[i].arrival_ns, stamps[i - 1].arrival_ns);
    }
  }
  EXPECT_EQ(summary.body_frames, stored);
  EXPECT_EQ(summary.depth_frames, 0u);
  EXPECT_FALSE(std::filesystem::exists(partial_name(folder / "session.h5")));
  for (const Finding& finding : verify_session(session, {}))
    EXPECT_NE(finding.severity, Severity::error) << finding.place << ": " << finding.text;
}

TEST(Recorder, DroppedFramesLeaveGapsInTheSequence) {
  const ScratchFolder folder;
  SensorSpec spec;
  spec.dropped_share = 0.2;
  SyntheticSource source = source_of(spec, {1, 0, 0}, 5.0);
  record(source, folder / "session.h5", {});
  const SessionReader session(folder / "session.h5");
  for (std::size_t s = 0; s < 4; ++s) {
    const std::uint64_t frames = session.counts(s).body_frames;
    EXPECT_GT(frames, 90u);
    EXPECT_LT(frames, 145u);
    const auto stamps = session.stamps(s, FrameStream::bodies, 0, frames);
    ASSERT_GT(stamps.size(), 2u);
    for (std::size_t i = 1; i < stamps.size(); ++i) EXPECT_GT(stamps[i].sequence, stamps[i - 1].sequence);
    EXPECT_GT(stamps.back().sequence, static_cast<std::int64_t>(frames));
  }
}

// 35 s as in the paper; every sensor has its own origin, phase and drift, and its PC another clock.
TEST(Recorder, TheClocksOfARecordingAreRecoveredFromIt) {
  const ScratchFolder folder;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SensorSpec spec;
    const SimulatedItem item{seed, 0, 0};
    SyntheticSource source = source_of(spec, item, 35.0);
    record(source, folder / "session.h5", {});
    const SessionReader session(folder / "session.h5");
    const auto rig = rig_of(spec, item);
    for (std::size_t s = 0; s < rig.size(); ++s) {
      const auto fitted = fit_sensor_clock(session, s);
      for (double t_s = 0.0; t_s <= 35.0; t_s += 0.5) {
        const SensorTime t = rig[s].first_exposure + duration_from_s(t_s);
        EXPECT_LT(std::abs((fitted(t) - rig[s].host_from_sensor(t)).seconds()), 2e-4)
            << "seed " << seed << " sensor " << s << " at " << t_s << " s";
      }
    }
  }
}

TEST(Recorder, WhenAskedToStopLeavesNothing) {
  const ScratchFolder folder;
  SyntheticSource source = source_of(spec_without_drops(), {1, 0, 0}, 1e6);
  int asked = 0;
  RecordOptions options;
  options.stop_requested = [&] { return ++asked == 3; };
  EXPECT_THROW(record(source, folder / "session.h5", options), Interrupted);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

// Depth, bodies and drop counts of two sensors, as a device would deliver them.
class ScriptedSource : public FrameSource {
 public:
  ScriptedSource() {
    for (const char* name : {"left", "right"}) {
      SensorDescription sensor;
      sensor.name = name;
      sensor.has_depth = true;
      header_.sensors.push_back(sensor);
    }
  }
  const SessionHeader& header() const override { return header_; }
  std::optional<SourceEvent> next() override {
    const auto i = number_++;
    const FrameStamp stamp{i, i * 333'333, 1'000'000'000 + i * 33'333'300};
    if (i == 4) return SourceEvent{1, DropCount{5, 6, 7}};
    if (i > 4) return std::nullopt;
    if (i % 2 == 0) return SourceEvent{0, DepthFrame{stamp, std::vector<std::uint16_t>(kDepthPixels, 1500)}};
    return SourceEvent{1, BodyFrame{stamp, {}, {}}};
  }

 private:
  SessionHeader header_;
  std::int64_t number_ = 0;
};

TEST(Recorder, StoresEveryKindOfEventWithItsSensor) {
  const ScratchFolder folder;
  ScriptedSource source;
  const RecordSummary summary = record(source, folder / "session.h5", {});
  EXPECT_EQ(summary.depth_frames, 2u);
  EXPECT_EQ(summary.body_frames, 2u);
  const SessionReader session(folder / "session.h5");
  EXPECT_EQ(session.counts(0).depth_frames, 2u);
  EXPECT_EQ(session.counts(1).depth_frames, 0u);
  EXPECT_EQ(session.counts(1).body_frames, 2u);
  EXPECT_EQ(session.drop_counts(1).at(0).in_queue, 7);
  std::vector<std::uint16_t> depth(kDepthPixels);
  session.depth_frame(0, 1, depth);
  EXPECT_EQ(depth, std::vector<std::uint16_t>(kDepthPixels, 1500));
}

}  // namespace
}  // namespace trilat
