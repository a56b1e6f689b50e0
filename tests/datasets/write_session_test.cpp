// SPDX-License-Identifier: MIT
#include "datasets/session/write_session.h"

#include <algorithm>
#include <fstream>

#include <gmock/gmock.h>

#include "datasets/session/clock/agent_clock.h"
#include "datasets/session/session_reader.h"
#include "tests/datasets/made_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

TEST(WriteSession, JoinsTheSensorsOfSeveralLogs) {
  const ScratchFolder folder;
  for (std::uint64_t l = 0; l < 2; ++l) {
    SessionHeader header = header_of(1, true);
    header.simulated = l == 1;
    header.sensors[0].name = l == 0 ? "left" : "right";
    EventLogWriter log(folder / std::to_string(l), head_with(header, l + 1));
    for (std::int64_t i = 0; i < 5; ++i) {
      log.append(0, body_frame_of(i, 1 + l));
      log.append(
          0, encode_depth_frame({i, i, i},
                                depth_of(static_cast<std::uint16_t>(i + 100 * static_cast<std::int64_t>(l))),
                                l == 0 ? ChunkCompression::blosc : ChunkCompression::deflate));
    }
    log.append(0, ClockExchange{1, 2, 3, 4});
    log.append(0, DropCount{1, 2, 3});
    log.finish();
  }
  const LogsWritten written = write_session({{folder / "0"}, {folder / "1"}}, folder / "s.h5");
  EXPECT_TRUE(written.whole());
  const SessionReader session(folder / "s.h5");
  EXPECT_TRUE(session.complete());
  EXPECT_TRUE(session.header().simulated);
  ASSERT_EQ(session.header().sensors.size(), 2u);
  EXPECT_EQ(session.header().sensors[1].name, "right");
  std::vector<std::uint16_t> depth(kDepthPixels);
  for (std::size_t s = 0; s < 2; ++s) {
    EXPECT_EQ(session.counts(s).bodies, 5 * (s + 1));
    EXPECT_EQ(session.counts(s).clock_exchanges, 1u);
    EXPECT_EQ(session.drop_counts(s).at(0).in_queue, 3);
    EXPECT_EQ(written.sensors[s].depth_frames, 5u);
    session.depth_frame(s, 4, depth);
    EXPECT_EQ(depth, depth_of(static_cast<std::uint16_t>(4 + 100 * s)));
    EXPECT_TRUE(session.notices(s).empty());
  }
}

TEST(WriteSession, RefusesOneLogTwiceAndTwoSensorsOfOneName) {
  const ScratchFolder folder;
  for (std::uint64_t l = 0; l < 2; ++l)
    EventLogWriter(folder / std::to_string(l), head_with(header_of(1), l + 1)).finish();
  std::filesystem::copy(folder / "0", folder / "copy");
  EXPECT_THAT(message_of([&] {
                write_session({{folder / "0"}, {folder / "copy"}}, folder / "s.h5");
              }),
              HasSubstr("is the same log as"));
  EXPECT_THAT(message_of([&] {
                write_session({{folder / "0"}, {folder / "1"}}, folder / "s.h5");
              }),
              HasSubstr("two sensors named \"k0\""));
  EXPECT_FALSE(std::filesystem::exists(folder / "s.h5"));
  EXPECT_FALSE(std::filesystem::exists(folder / "s.h5.partial"));
}

// Half of it is writing, half reading back: shares rise from 0 to 1.
TEST(WriteSession, ClosingARecordingTellsItsProgress) {
  const ScratchFolder folder;
  {
    EventLogWriter log(folder / "a.trilog", head_with(header_of(1, true)));
    for (std::int64_t i = 0; i < 200; ++i) {
      log.append(0, body_frame_of(i, 1));
      log.append(0, encode_depth_frame({i, i, i}, depth_of(1), ChunkCompression::deflate));
    }
    log.finish();
  }
  std::vector<double> shares;
  std::string left;
  close_recording({{folder / "a.trilog"}}, folder / "s.h5", left, [&](double share) {
    shares.push_back(share);
    return true;
  });
  EXPECT_EQ(left, "");
  ASSERT_GE(shares.size(), 2u);
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_GE(shares.front(), 0.0);
  EXPECT_LE(shares.back(), 1.0);
  EXPECT_TRUE(std::ranges::any_of(shares, [](double share) { return share >= 0.5; }));
  EXPECT_TRUE(std::ranges::any_of(shares, [](double share) { return share < 0.5; }));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.trilog"));
}

TEST(WriteSession, WhatIsDamagedCostsNoMoreThanItselfAndIsReported) {
  const ScratchFolder folder;
  {
    EventLogWriter log(folder / "a", head_with(header_of(1, true)));
    for (std::int64_t i = 0; i < 6; ++i) {
      BodyFrame frame = body_frame_of(i, 1);
      if (i == 2) frame.stamp.arrival_ns = std::int64_t{1} << 61;
      log.append(0, frame);
    }
    EncodedDepthFrame depth = encode_depth_frame({1, 1, 1}, depth_of(1), ChunkCompression::deflate);
    depth.chunk[depth.chunk.size() / 2] ^= std::byte{1};  // by the sender: the log's checksum is right
    log.append(0, depth);
    log.append(0, ClockExchange{1, std::int64_t{1} << 61, 3, 4});
  }  // not finished
  std::string bytes = read_file(folder / "a");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  std::ofstream(folder / "a", std::ios::binary) << bytes;
  const LogsWritten written = write_session({{folder / "a"}}, folder / "s.h5");
  EXPECT_FALSE(written.whole());
  EXPECT_EQ(written.logs.at(0).gap_count, 1u);
  const SessionReader session(folder / "s.h5");
  EXPECT_TRUE(session.complete());
  EXPECT_EQ(written.sensors[0].left_out + session.counts(0).body_frames + session.counts(0).depth_frames, 6u);
  EXPECT_GE(session.counts(0).body_frames, 4u);
  EXPECT_EQ(session.counts(0).depth_frames, 0u);
  EXPECT_EQ(session.counts(0).clock_exchanges, 0u);
  EXPECT_THAT(session.notices(0).at(0).text, HasSubstr("bytes at 1 places of its log are damaged"));
  EXPECT_THAT(session.notices(0).at(0).text, HasSubstr("was not ended in order"));
}

// Its first log never came: its agent was killed before.
TEST(WriteSession, ASensorThatComesLateHasLostTheBeginning) {
  const ScratchFolder folder;
  for (const double late_s : {0.5, 10.0}) {
    LogHead own = new_log_head({});
    own.recording = own.id;
    {
      EventLogWriter log(folder / "own", own);
      log.begin();
      log.finish();
      LogHead head = new_log_head(header_of(1), own.id, "k1");
      EventLogWriter agent(folder / "agent", head);
      for (std::int64_t i = 0; i < 10; ++i) {
        BodyFrame frame = body_frame_of(i, 1);
        frame.stamp.arrival_ns = head.start_ns + static_cast<std::int64_t>(1e9 * late_s) + i * 33'333'300;
        agent.append(0, frame);
      }
      agent.finish();
    }
    const LogsWritten written = write_session({{folder / "agent"}, {folder / "own"}}, folder / "s.h5");
    EXPECT_EQ(written.sensors.at(0).name, "k1");
    EXPECT_NEAR(static_cast<double>(written.sensors[0].drops.at_source),
                late_s > 1.0 ? 30.0 * late_s - 1.0 : 0.0, 2.0);
    const SessionReader session(folder / "s.h5");
    EXPECT_EQ(session.drop_counts(0).empty(), late_s < 1.0);
    for (const char* name : {"own", "agent"}) std::filesystem::remove(folder / name);
  }
}

TEST(WriteSession, TheGapBeforeALogWithoutFramesCounts) {
  const ScratchFolder folder;
  for (int run = 0; run < 2; ++run) {
    LogHead head = new_log_head(header_of(1), 0, "k1");
    head.start_unix_ns += run * 5'000'000'000;
    EventLogWriter log(folder / std::to_string(run), head);
    BodyFrame frame = body_frame_of(run, 1);
    frame.stamp.arrival_ns = head.start_ns;
    if (run == 0) log.append(0, frame);
    log.finish();
  }
  const LogsWritten written = write_session({{folder / "1"}, {folder / "0"}}, folder / "s.h5");
  EXPECT_NEAR(static_cast<double>(written.sensors.at(0).drops.at_source), 149.0, 2.0);
  EXPECT_EQ(SessionReader(folder / "s.h5").counts(0).body_frames, 1u);
}

// The computer of an agent was started anew in the middle of a recording: its monotonic clock began again,
// and its wall clock was 2 s off. Its exchanges with the recorder give the offset of both clocks.
TEST(WriteSession, AComputerThatWasStartedAnewIsPlacedByItsExchanges) {
  const ScratchFolder folder;
  constexpr std::int64_t kSecond = 1'000'000'000;
  for (std::int64_t run = 0; run < 2; ++run) {
    LogHead head = new_log_head(header_of(1), 9, "left");
    const std::int64_t host_ns = (100 + 20 * run) * kSecond, ahead_ns = (run == 0 ? 1000 : -90) * kSecond;
    head.start_ns = host_ns + ahead_ns;
    head.start_unix_ns = 1'700'000'000 * kSecond + host_ns + run * 2 * kSecond;
    EventLogWriter log(folder / std::to_string(run), head);
    for (std::int64_t i = 0; i < 20; ++i) {
      const std::int64_t t1_ns = host_ns + i * kSecond / 4, t2_ns = t1_ns + 100'000 + ahead_ns;
      log.append(0, ClockExchange{t1_ns, t2_ns, t2_ns + 50'000, t1_ns + 250'000});
    }
    BodyFrame frame = body_frame_of(run, 1);
    frame.stamp.arrival_ns = head.start_ns + kSecond;
    log.append(0, frame);
    log.finish();
  }
  write_session({{folder / "0"}, {folder / "1"}}, folder / "s.h5");
  const SessionReader session(folder / "s.h5");
  const AgentClock clock = fit_agent_clock(session.clock_exchanges(0));
  EXPECT_LT(clock.deviation.ns, 10'000);
  for (std::uint64_t run = 0; run < 2; ++run) {
    const FrameStamp stamp = session.stamps(0, FrameStream::bodies, run, 1)[0];
    EXPECT_NEAR(clock({stamp.arrival_ns}).ns,
                static_cast<double>((101 + 20 * static_cast<std::int64_t>(run)) * kSecond), 1e4)
        << run;
  }
}

// Two computers without a network: the second was started 1000 s later, and saw the same second by the wall
// clock.
TEST(WriteSession, LogsThatWereRecordedAloneShareTheWallClock) {
  const ScratchFolder folder;
  for (std::int64_t k = 0; k < 2; ++k) {
    LogHead head = new_log_head(header_of(1), 0, k == 0 ? "left" : "right");
    head.start_ns = 5'000'000'000'000 - k * 1'000'000'000'000;
    head.start_unix_ns = 1'700'000'000'000'000'000 + k * 100'000'000;
    EventLogWriter log(folder / std::to_string(k), head);
    BodyFrame frame = body_frame_of(1, 1);
    frame.stamp.arrival_ns = head.start_ns + 1'000'000'000 - k * 100'000'000;
    log.append(0, frame);
    log.finish();
  }
  write_session({{folder / "0"}, {folder / "1"}}, folder / "s.h5");
  const SessionReader session(folder / "s.h5");
  for (std::size_t s = 0; s < 2; ++s)
    EXPECT_EQ(session.stamps(s, FrameStream::bodies, 0, 1)[0].arrival_ns, 5'001'000'000'000);
  EXPECT_TRUE(session.notices(0).empty());
  EXPECT_THAT(session.notices(1).at(0).text, HasSubstr("by the wall clocks of both computers"));
}

TEST(WriteSession, ARecordingIsClosedByTakingItsLogAway) {
  const ScratchFolder folder;
  for (const bool finish : {true, false}) {
    {
      EventLogWriter log(folder / "a", head_with(header_of(1)));
      for (std::int64_t i = 0; i < 100; ++i) log.append(0, body_frame_of(i, 1));
      if (finish) log.finish();
    }
    std::string left;
    close_recording({{folder / "a"}}, folder / "s.h5", left);
    EXPECT_EQ(left, "");
    EXPECT_EQ(SessionReader(folder / "s.h5").counts(0).body_frames, 100u);
    EXPECT_FALSE(std::filesystem::exists(folder / "a"));
  }
}

// The log stays, since it holds frames that the session does not.
TEST(WriteSession, ALogThatCouldNotBeReadWholeStaysBesideTheSession) {
  const ScratchFolder folder;
  {
    EventLogWriter log(folder / "a", head_with(header_of(1)));
    for (std::int64_t i = 0; i < 100; ++i) log.append(0, body_frame_of(i, 1));
    log.finish();
  }
  std::string bytes = read_file(folder / "a");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  std::ofstream(folder / "a", std::ios::binary) << bytes;
  std::string left;
  const LogsWritten written = close_recording({{folder / "a"}}, folder / "s.h5", left);
  EXPECT_FALSE(written.whole());
  EXPECT_EQ(left, "not all of the log could be read back");
  EXPECT_TRUE(std::filesystem::exists(folder / "a"));
  EXPECT_EQ(SessionReader(folder / "s.h5").counts(0).body_frames, 99u);
}

TEST(WriteSession, ALogOfWhichFramesWereLeftOutStaysBesideTheSession) {
  const ScratchFolder folder;
  {
    EventLogWriter log(folder / "a", head_with(header_of(1)));
    for (std::int64_t i = 0; i < 100; ++i) {
      BodyFrame frame = body_frame_of(i, 1);
      if (i == 50) frame.stamp.arrival_ns = std::int64_t{1} << 61;  // no time
      log.append(0, frame);
    }
    log.finish();
  }
  std::string left;
  const LogsWritten written = close_recording({{folder / "a"}}, folder / "s.h5", left);
  EXPECT_EQ(written.sensors.at(0).left_out, 1u);
  EXPECT_EQ(left, "not all of the log could be read back");
  EXPECT_TRUE(std::filesystem::exists(folder / "a"));
  EXPECT_EQ(SessionReader(folder / "s.h5").counts(0).body_frames, 99u);
}

}  // namespace
}  // namespace trilat
