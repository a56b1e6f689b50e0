// SPDX-License-Identifier: MIT
#include "recorders/capture.h"

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_verify.h"
#include "recorders/open_source.h"
#include "tests/recorders/pattern_source.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::Contains;
using testing::HasSubstr;
using Sources = std::vector<std::unique_ptr<FrameSource>>;

template <class... Source>
Sources sources_of(std::unique_ptr<Source>... source) {
  Sources sources;
  (sources.push_back(std::move(source)), ...);
  return sources;
}

void expect_pattern(const SessionReader& session, std::size_t sensor, std::size_t pattern_sensor,
                    std::uint64_t frames) {
  ASSERT_EQ(session.counts(sensor).body_frames, frames);
  ASSERT_EQ(session.counts(sensor).depth_frames, frames);
  const auto bodies = session.body_frames(sensor, 0, frames);
  const auto stamps = session.stamps(sensor, FrameStream::depth, 0, frames);
  std::vector<std::uint16_t> depth(kDepthPixels);
  for (std::size_t i = 0; i < frames; ++i) {
    const auto frame = static_cast<std::int64_t>(i);
    const BodyFrame expected = PatternSource::bodies_of(pattern_sensor, frame);
    EXPECT_EQ(bodies[i].stamp.sequence, frame);
    EXPECT_EQ(stamps[i].arrival_ns - stamps[0].arrival_ns, 33'333'300 * frame);
    ASSERT_EQ(bodies[i].bodies.size(), expected.bodies.size());
    for (std::size_t b = 0; b < expected.bodies.size(); ++b)
      EXPECT_EQ(bodies[i].bodies[b].position_m, expected.bodies[b].position_m);
    session.depth_frame(sensor, i, depth);
    EXPECT_EQ(depth, PatternSource::depth_of(pattern_sensor, frame)) << "frame " << i;
  }
}

TEST(Capture, StoresWhatAllSourcesDeliverInTheirOrder) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.spool.limit_bytes = 3 << 20;  // sources have to wait
  const CaptureSummary summary = capture(
      sources_of(std::make_unique<PatternSource>(2, 40), std::make_unique<PatternSource>(1, 25, false, "m")),
      folder / "session.h5", options);
  EXPECT_EQ(summary.end, CaptureEnd::source_ended);
  EXPECT_FALSE(summary.lost_frames());
  const SessionReader session(folder / "session.h5");
  EXPECT_TRUE(session.complete());
  expect_pattern(session, 0, 0, 40);
  expect_pattern(session, 1, 1, 40);
  expect_pattern(session, 2, 0, 25);
  EXPECT_EQ(session.counts(1).clock_exchanges, 40u);
}

// Of a source that waits for its next frame, whenever that is.
TEST(LiveSource, StopEndsTheWaitOfAnotherThread) {
  for (int round = 0; round < 20; ++round) {
    LiveOptions slow;
    slow.speed = 0.01;
    LiveSource source(std::make_unique<PatternSource>(1, 1000), slow);
    std::thread stopper([&] { source.stop(); });
    std::size_t events = 0;
    while (source.next()) ++events;
    stopper.join();
    EXPECT_LT(events, 3000u);  // all there are, which would take hours
  }
}

TEST(LiveSource, MovesStampsAndExchangesFromTheFramesClockToNow) {
  constexpr std::int64_t kOrigin_ns = 15'000'000;
  LiveSource source(std::make_unique<PatternSource>(1, 3),
                    {.speed = 50.0, .one_clock = true, .origin_ns = kOrigin_ns});
  const std::int64_t by_ns = source.start() - kOrigin_ns;
  std::size_t frames = 0, exchanges = 0;
  while (const auto event = source.next()) {
    if (const auto* bodies = std::get_if<BodyFrame>(&event->data)) {
      ++frames;
      EXPECT_EQ(bodies->stamp.arrival_ns, PatternSource::stamp_of(bodies->stamp.sequence).arrival_ns + by_ns);
    }
    if (const auto* exchange = std::get_if<ClockExchange>(&event->data)) {
      ++exchanges;
      EXPECT_EQ(exchange->t1_ns % 1'000'000, (exchange->t4_ns - 3) % 1'000'000);
      EXPECT_LE(std::abs(exchange->t1_ns - by_ns), 2);
    }
  }
  EXPECT_EQ(frames, 3u);
  EXPECT_EQ(exchanges, 3u);
}

TEST(Capture, WhatALiveSourceDeliversWithoutRoomIsDroppedAndCounted) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.spool.limit_bytes = 1 << 20;  // two frames, and they come faster than they can be compressed
  const CaptureSummary summary =
      capture(sources_of(std::make_unique<PatternSource>(1, 100, true)), folder / "session.h5", options);
  EXPECT_TRUE(summary.lost_frames());
  const SessionReader session(folder / "session.h5");
  const auto& counts = session.counts(0);
  EXPECT_EQ(counts.body_frames, 100u);  // what is small is never dropped
  EXPECT_LT(counts.depth_frames, 100u);
  EXPECT_EQ(counts.depth_frames + static_cast<std::uint64_t>(session.drop_counts(0).back().in_queue), 100u);
  EXPECT_EQ(summary.last.sensors[0].lost_in_queue, session.drop_counts(0).back().in_queue);
}

// Breaks after some frames, or falls silent.
class UnreliableSource : public PatternSource {
 public:
  UnreliableSource(std::int64_t frames, double silence_s)
      : PatternSource(1, 1000, true, "u"), frames_(frames), silence_s_(silence_s) {}
  std::optional<SourceEvent> next() override {
    if (events_++ == 3 * frames_) {
      if (silence_s_ == 0.0) throw std::runtime_error("the cable was pulled");
      std::this_thread::sleep_for(std::chrono::duration<double>(silence_s_));
    }
    return events_ > 6 * frames_ ? std::nullopt : PatternSource::next();
  }

 private:
  std::int64_t frames_, events_ = 0;
  double silence_s_;
};

std::vector<std::string> notices_of(const SessionReader& session, std::size_t sensor) {
  std::vector<std::string> texts;
  for (const SensorNotice& notice : session.notices(sensor)) texts.push_back(notice.text);
  return texts;
}

TEST(Capture, ASourceThatBreaksIsToldAndTheOthersGoOn) {
  const ScratchFolder folder;
  const CaptureSummary summary =
      capture(sources_of(std::make_unique<PatternSource>(1, 30), std::make_unique<UnreliableSource>(7, 0.0)),
              folder / "session.h5", {});
  EXPECT_TRUE(summary.source_failed);
  const SessionReader session(folder / "session.h5");
  expect_pattern(session, 0, 0, 30);
  expect_pattern(session, 1, 0, 7);
  EXPECT_THAT(notices_of(session, 1), Contains(HasSubstr("the cable was pulled")));
}

// A busy machine may silence a sensor for 0.1 s more than once: each time both are reported.
TEST(Capture, ASilenceIsReportedOnceAndWhenItEnds) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.spool.silence_s = 0.1;
  options.look_period_s = 0.02;
  capture(sources_of(std::make_unique<UnreliableSource>(4, 0.6)), folder / "session.h5", options);
  const SessionReader session(folder / "session.h5");
  const auto notices = notices_of(session, 0);
  for (const char* stream : {"bodies", "depth"}) {
    const std::string begins = fmt::format("no frame of {} for 0.1 s", stream),
                      ends = fmt::format("frames of {} again", stream);
    std::vector<std::string> reported;
    std::ranges::copy_if(notices, std::back_inserter(reported),
                         [&](const auto& text) { return text == begins || text == ends; });
    ASSERT_GE(reported.size(), 2) << stream;
    for (std::size_t k = 0; k < reported.size(); ++k) EXPECT_EQ(reported[k], k % 2 == 0 ? begins : ends) << k;
  }
}

// Bodies of a sensor, of which every fifth frame is missing and of which no depth comes.
class GappySource : public FrameSource {
 public:
  explicit GappySource(std::int64_t frames) : frames_(frames) {
    SensorDescription sensor;
    sensor.name = "k1";
    sensor.source = "made";
    sensor.has_depth = true;
    header_.sensors = {sensor};
  }
  const SessionHeader& header() const override { return header_; }
  std::optional<SourceEvent> next() override {
    if (frame_ % 5 == 4) ++frame_;
    if (frame_ >= frames_) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return SourceEvent{0, PatternSource::bodies_of(0, frame_++)};
  }

 private:
  SessionHeader header_;
  std::int64_t frames_, frame_ = 0;
};

TEST(Capture, FramesThatAreMissingByTheirNumbersAreCountedAndADeadStreamIsNamed) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.spool.silence_s = 0.1;
  options.look_period_s = 0.02;
  const CaptureSummary summary =
      capture(sources_of(std::make_unique<GappySource>(50)), folder / "session.h5", options);
  EXPECT_TRUE(summary.lost_frames());
  EXPECT_EQ(summary.last.sensors[0].lost_at_source, 9);  // the last one leaves no gap
  const SessionReader session(folder / "session.h5");
  EXPECT_EQ(session.drop_counts(0).back().at_source, 9);
  EXPECT_THAT(notices_of(session, 0), Contains("no frame of depth for 0.1 s"));
  EXPECT_THAT(notices_of(session, 0), testing::Not(Contains(HasSubstr("bodies"))));
}

TEST(Capture, WhenAskedToStopClosesTheFileWithAllThatCame) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.look_period_s = 0.02;
  bool stop = false;
  options.on_status = [&](const CaptureStatus& status) { stop = status.sensors[0].depth_frames > 20; };
  options.stop_requested = [&] { return stop; };
  const CaptureSummary summary =
      capture(sources_of(std::make_unique<PatternSource>(1, 1'000'000)), folder / "session.h5", options);
  EXPECT_EQ(summary.end, CaptureEnd::stop_requested);
  const SessionReader session(folder / "session.h5");
  EXPECT_TRUE(session.complete());
  EXPECT_GT(session.counts(0).depth_frames, 20u);
  expect_pattern(session, 0, 0, session.counts(0).depth_frames);
  EXPECT_FALSE(std::filesystem::exists(log_name(folder / "session.h5")));
}

TEST(Capture, EndsInOrderWhenTheDiskIsNearlyFull) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.look_period_s = 0.02;
  options.reserve_bytes = std::uint64_t{1} << 62;
  const CaptureSummary summary =
      capture(sources_of(std::make_unique<PatternSource>(1, 1'000'000)), folder / "session.h5", options);
  EXPECT_EQ(summary.end, CaptureEnd::disk_full);
  EXPECT_TRUE(SessionReader(folder / "session.h5").complete());
}

// Every fifth depth frame has only half its pixels.
class TornSource : public PatternSource {
 public:
  TornSource() : PatternSource(1, 15) {}
  std::optional<SourceEvent> next() override {
    auto event = PatternSource::next();
    if (!event) return event;
    if (auto* depth = std::get_if<DepthFrame>(&event->data); depth && depth->stamp.sequence % 5 == 0)
      depth->depth_mm.resize(kDepthPixels / 2);
    return event;
  }
};

TEST(Capture, TornFramesAreLeftOutAndCounted) {
  const ScratchFolder folder;
  const CaptureSummary summary =
      capture(sources_of(std::make_unique<TornSource>()), folder / "session.h5", {});
  const SessionReader session(folder / "session.h5");
  EXPECT_EQ(session.counts(0).body_frames, 15u);
  EXPECT_EQ(session.counts(0).depth_frames, 12u);
  EXPECT_EQ(summary.last.sensors[0].lost_in_queue, 3);
}

// One of them in the file would keep a reader from opening it.
class ImpossibleSource : public PatternSource {
 public:
  ImpossibleSource() : PatternSource(1, 10) {}
  std::optional<SourceEvent> next() override {
    auto event = PatternSource::next();
    if (!event) return event;
    if (auto* frame = std::get_if<BodyFrame>(&event->data); frame && frame->stamp.sequence == 4)
      frame->stamp.device_ticks = std::int64_t{1} << 62;
    if (auto* exchange = std::get_if<ClockExchange>(&event->data); exchange && exchange->t1_ns == 5)
      exchange->t2_ns = -(std::int64_t{1} << 61);
    return event;
  }
};

// An implausible clock exchange is dropped and not counted as a lost frame.
TEST(Capture, TimesThatNoClockShowsAreLeftOutAndFramesOfSuchCounted) {
  const ScratchFolder folder;
  const CaptureSummary summary =
      capture(sources_of(std::make_unique<ImpossibleSource>()), folder / "session.h5", {});
  EXPECT_EQ(summary.last.sensors[0].lost_in_queue, 1);
  const SessionReader session(folder / "session.h5");
  EXPECT_EQ(session.body_frames(0, 0, session.counts(0).body_frames).size(), 9u);
  EXPECT_EQ(session.clock_exchanges(0).size(), 9u);
}

// Seconds on the steady clock at which a source was made, delivered the first and the last of its last
// frames, and was stopped.
struct SourceTimes {
  std::atomic<double> made{0.0}, last_frames{0.0}, silent{0.0}, stopped{0.0};
  static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
};

// Live, and silent from its 20th frame on.
class DyingSource : public PatternSource {
 public:
  explicit DyingSource(SourceTimes& times) : PatternSource(1, 1'000'000, true), times_(times) {
    times_.made = SourceTimes::now();
  }
  std::optional<SourceEvent> next() override {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (events_ == kEvents - 3) times_.last_frames = SourceTimes::now();
    if (events_++ < kEvents) return PatternSource::next();
    times_.silent = SourceTimes::now();
    while (!silent_.load()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return std::nullopt;
  }
  void stop() override {
    times_.stopped = SourceTimes::now();
    silent_ = true;
  }

 private:
  static constexpr std::int64_t kEvents = 60;
  SourceTimes& times_;
  std::int64_t events_ = 0;
  std::atomic<bool> silent_{false};
};

TEST(Capture, ASensorThatIsSilentToTheEndHasLostWhatItWouldHaveDelivered) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.spool.silence_s = 0.2;
  options.look_period_s = 0.02;
  options.duration_s = 2.5;
  std::vector<std::string> notices;
  options.on_notice = [&](const std::string& text) { notices.push_back(text); };
  SourceTimes times;
  const CaptureSummary summary = capture(
      sources_of(std::make_unique<DyingSource>(times), std::make_unique<PatternSource>(1, 10, true, "m")),
      folder / "session.h5", options);
  EXPECT_EQ(summary.end, CaptureEnd::duration_over);
  // 30 frames a second of bodies and of depth, each rounded down
  EXPECT_GE(summary.last.sensors[0].lost_at_source, 2 * 30 * (times.made + 2.5 - times.silent) - 2);
  EXPECT_LE(summary.last.sensors[0].lost_at_source, 2 * 30 * (times.stopped - times.last_frames));
  EXPECT_EQ(summary.last.sensors[1].lost_at_source, 0);  // its source ended
  EXPECT_EQ(SessionReader(folder / "session.h5").drop_counts(0).back().at_source,
            summary.last.sensors[0].lost_at_source);
  EXPECT_THAT(notices, Contains("k0: no frame of depth for 0.2 s"));
  EXPECT_THAT(notices, testing::Not(Contains(HasSubstr("m0"))));
}

// Live, and silent from its beginning.
class MuteSource : public PatternSource {
 public:
  MuteSource() : PatternSource(1, 10, true) {}
  std::optional<SourceEvent> next() override {
    while (!stopped_) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return std::nullopt;
  }
  void stop() override { stopped_ = true; }

 private:
  std::atomic<bool> stopped_{false};
};

TEST(Capture, ASensorThatNeverDeliversHasLostAll) {
  const ScratchFolder folder;
  CaptureOptions options;
  options.spool.silence_s = 0.2;
  options.look_period_s = 0.02;
  options.duration_s = 1.0;
  const CaptureSummary summary =
      capture(sources_of(std::make_unique<MuteSource>()), folder / "session.h5", options);
  EXPECT_GE(summary.last.sensors[0].lost_at_source, 2 * 28);  // a second of bodies and of depth
}

TEST(Capture, TwoSensorsOfOneNameAreRefused) {
  const ScratchFolder folder;
  EXPECT_THAT(message_of([&] {
                capture(
                    sources_of(std::make_unique<PatternSource>(1, 1), std::make_unique<PatternSource>(1, 1)),
                    folder / "session.h5", {});
              }),
              HasSubstr("two sensors named \"k0\""));
}

}  // namespace
}  // namespace trilat
