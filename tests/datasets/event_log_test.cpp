// SPDX-License-Identifier: MIT
#include "datasets/session/event_log.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>

#include <gmock/gmock.h>

#include "datasets/base/philox.h"
#include "datasets/session/clock/agent_clock.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/write_session.h"
#include "tests/datasets/made_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

// An event as text that tells any two apart.
std::string text_of(std::size_t sensor, const LogEvent& event) {
  std::string text = std::to_string(sensor) + " " + std::to_string(event.index());
  const auto add = [&](const auto&... values) { ((text += " " + std::to_string(values)), ...); };
  const auto add_stamp = [&](const FrameStamp& stamp) {
    add(stamp.sequence, stamp.device_ticks, stamp.arrival_ns);
  };
  if (const auto* frame = std::get_if<BodyFrame>(&event)) {
    add_stamp(frame->stamp);
    for (const float value : frame->floor_plane) add(value);
    for (const Body& body : frame->bodies) {
      add(body.tracking_id);
      for (std::size_t j = 0; j < kJointCount; ++j)
        add(body.position_m[j][0], body.position_m[j][2], body.orientation_xyzw[j][3],
            body.tracking_state[j]);
      add(body.hand_state[1], body.hand_confidence[0]);
    }
  } else if (const auto* depth = std::get_if<EncodedDepthFrame>(&event)) {
    add_stamp(depth->stamp);
    add(static_cast<int>(depth->compression));
    for (const std::byte byte : depth->chunk) text += static_cast<char>(byte);
  } else if (const auto* exchange = std::get_if<ClockExchange>(&event)) {
    add(exchange->t1_ns, exchange->t2_ns, exchange->t3_ns, exchange->t4_ns);
  } else if (const auto* drops = std::get_if<DropCount>(&event)) {
    add(drops->host_ns, drops->at_source, drops->in_queue);
  } else if (const auto* notice = std::get_if<SensorNotice>(&event)) {
    add(notice->host_ns);
    text += notice->text;
  }
  return text;
}

// Returns the head of a recorder's log, whose `id` differs from log to log.
LogHead head_with(SessionHeader session, std::uint64_t id = 7) {
  return {id, 0, 5'000'000'000, 0, "", std::move(session)};
}

// Every kind of event, some with contents that look like the beginning of a record.
std::vector<std::pair<std::size_t, LogEvent>> some_events() {
  const std::vector<std::byte> chunk{std::byte{9}, std::byte{0}, std::byte{0},    std::byte{0},
                                     std::byte{5}, std::byte{0}, std::byte{0x54}, std::byte{0x4c}};
  std::vector<std::pair<std::size_t, LogEvent>> events;
  for (std::int64_t i = 0; i < 3; ++i) {
    const auto s = static_cast<std::size_t>(i % 2);
    events.emplace_back(s, body_frame_of(i, s));
    events.emplace_back(s, EncodedDepthFrame{{i, 2 * i, 3 * i}, chunk, ChunkCompression::none});
    events.emplace_back(s, ClockExchange{i, -i, i + 2, i + 3});
    events.emplace_back(s, DropCount{i, i + 1, i + 2});
    events.emplace_back(s, SensorNotice{i, "unplugged, f\xc3\xbcr " + std::to_string(i) + " s"});
  }
  return events;
}

std::vector<std::string> write_some(const std::filesystem::path& path, bool finish = true) {
  EventLogWriter log(path, head_with(header_of(2, true)));
  std::vector<std::string> texts;
  for (const auto& [sensor, event] : some_events()) {
    log.append(sensor, event);
    texts.push_back(text_of(sensor, event));
  }
  if (finish) log.finish("the cable was pulled");
  return texts;
}

std::vector<std::byte> bytes_of_file(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

struct Scanned {
  std::vector<std::string> texts;
  std::optional<LogSummary> summary;  // none: it was refused
};

// `piece`: bytes that come at once.
Scanned scan(std::span<const std::byte> bytes, std::size_t piece) {
  Scanned result;
  LogScanner scanner("some.trilog", [&](std::size_t sensor, LogEvent&& event) {
    result.texts.push_back(text_of(sensor, event));
  });
  try {
    for (std::size_t at = 0; at < bytes.size(); at += piece)
      scanner.feed(bytes.subspan(at, std::min(piece, bytes.size() - at)));
    result.summary = scanner.finish();
  } catch (const InputError&) {
  }
  return result;
}

TEST(EventLog, WhatIsWrittenIsReadBack) {
  const ScratchFolder folder;
  const auto texts = write_some(folder / "a.trilog");
  std::vector<std::string> read;
  const LogSummary log = read_event_log(folder / "a.trilog", [&](std::size_t sensor, LogEvent&& event) {
    read.push_back(text_of(sensor, event));
  });
  EXPECT_EQ(read, texts);
  EXPECT_EQ(log.head.id, 7u);
  EXPECT_EQ(log.head.start_ns, 5'000'000'000);
  ASSERT_EQ(log.head.session.sensors.size(), 2u);
  EXPECT_EQ(log.head.session.sensors[1].serial, "00001");
  EXPECT_TRUE(log.finished);
  EXPECT_EQ(log.problem, "the cable was pulled");
  EXPECT_EQ(log.gap_count, 0u);
  EXPECT_EQ(log.end, std::filesystem::file_size(folder / "a.trilog"));
  EXPECT_EQ(head_of_event_log(folder / "a.trilog").id, 7u);
}

TEST(EventLog, HoweverItsBytesComeTheEventsAreTheSame) {
  const ScratchFolder folder;
  const auto texts = write_some(folder / "a.trilog");
  const auto bytes = bytes_of_file(folder / "a.trilog");
  for (const std::size_t piece : {1u, 7u, 1000u}) EXPECT_EQ(scan(bytes, piece).texts, texts) << piece;
}

TEST(EventLog, CutAnywhereItHoldsTheWholeRecordsBeforeTheCut) {
  const ScratchFolder folder;
  const auto texts = write_some(folder / "a.trilog");
  const auto bytes = bytes_of_file(folder / "a.trilog");
  std::size_t records = 0;
  for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
    const Scanned scanned = scan(std::span(bytes).first(cut), 4096);
    const std::size_t read = scanned.texts.size();
    ASSERT_TRUE(std::equal(scanned.texts.begin(), scanned.texts.end(), texts.begin(),
                           texts.begin() + static_cast<std::ptrdiff_t>(read)));
    ASSERT_TRUE(read == records || read == records + 1) << cut;
    records = read;
    if (!scanned.summary) continue;
    EXPECT_FALSE(scanned.summary->finished);
    EXPECT_EQ(scanned.summary->end + scanned.summary->cut_bytes, cut);
    EXPECT_EQ(scanned.summary->gap_count, 0u);
  }
  EXPECT_EQ(records, texts.size());
}

TEST(EventLog, ADamagedByteCostsItsRecordAlone) {
  const ScratchFolder folder;
  const auto texts = write_some(folder / "a.trilog");
  auto bytes = bytes_of_file(folder / "a.trilog");
  std::size_t refused = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    bytes[at] ^= std::byte{0x10};
    const Scanned scanned = scan(bytes, 512);
    bytes[at] ^= std::byte{0x10};
    if (!scanned.summary) {
      ++refused;
      continue;
    }
    ASSERT_GE(scanned.texts.size() + 1, texts.size()) << at;
    for (std::size_t i = 0, k = 0; i < scanned.texts.size(); ++i, ++k) {
      if (scanned.texts[i] != texts[k]) ++k;
      ASSERT_EQ(scanned.texts[i], texts.at(k)) << at;
    }
    ASSERT_EQ(scanned.summary->gap_count + (scanned.summary->cut_bytes > 0), 1u) << at;
    if (scanned.summary->gap_count == 1) {
      EXPECT_LE(scanned.summary->gaps[0].offset, at);
      EXPECT_GT(scanned.summary->gaps[0].offset + scanned.summary->gaps[0].bytes, at);
    }
  }
  EXPECT_GT(refused, 8u);  // the magic and the head
  EXPECT_LT(refused, bytes.size() / 2);
}

// 130 MB with two marks, cut at random places: the end is where a reading of all of it finds it.
TEST(EventLog, ItsEndIsFoundFromTheLastMark) {
  const ScratchFolder folder;
  const auto path = folder / "long.trilog";
  std::vector<std::uint64_t> ends;
  {
    EventLogWriter log(path, head_with(header_of(1, true)));
    for (std::int64_t i = 0; i < 310; ++i)
      log.append(
          0, encode_depth_frame({i, i, i}, depth_of(static_cast<std::uint16_t>(i)), ChunkCompression::none));
    log.finish();
  }
  read_event_log(path, [](std::size_t, LogEvent&&) {});
  std::uint64_t size = std::filesystem::file_size(path);
  EXPECT_EQ(end_of_event_log(path).offset, size);
  EXPECT_TRUE(end_of_event_log(path).finished);
  const RandomStream random{1, Purpose::sensor_drop, 0};
  for (std::uint32_t trial = 0; trial < 4; ++trial) {
    size -= static_cast<std::uint64_t>(random.uniform(trial) * 15e6);
    std::filesystem::resize_file(path, size);
    const std::uint64_t end = end_of_event_log(path).offset;
    EXPECT_FALSE(end_of_event_log(path).finished);
    EXPECT_EQ(end, read_event_log(path, [](std::size_t, LogEvent&&) {}).end);
    EXPECT_LE(end, size);
    EXPECT_GT(end + 450'000, size);
  }
}

TEST(EventLog, IsLockedWhileItIsWrittenAndNeverWrittenOver) {
  const ScratchFolder folder;
  {
    const EventLogWriter log(folder / "a.trilog", head_with(header_of(1)));
    EXPECT_TRUE(is_being_written(folder / "a.trilog"));
    EXPECT_THAT(message_of([&] { write_session({{folder / "a.trilog"}}, folder / "s.h5"); }),
                HasSubstr("is being written by a recording that still runs"));
    EXPECT_THAT(message_of([&] { AppendFile(folder / "a.trilog", AppendFile::Open::extend, 0); }),
                HasSubstr("is being written by another process"));
  }
  EXPECT_FALSE(is_being_written(folder / "a.trilog"));
  EXPECT_THAT(message_of([&] { EventLogWriter(folder / "a.trilog", head_with(header_of(1))); }),
              HasSubstr("exists"));
  EXPECT_EQ(std::filesystem::status(folder / "a.trilog").permissions(), std::filesystem::perms(0600));
}

TEST(EventLog, OtherFilesAreRefusedWithTheReason) {
  const ScratchFolder folder;
  const auto refusal_of_text = [&](const std::string& text) {
    std::ofstream(folder / "a.trilog", std::ios::binary) << text;
    return message_of([&] { read_event_log(folder / "a.trilog", [](std::size_t, LogEvent&&) {}); });
  };
  EXPECT_THAT(refusal_of_text("x,y,z\n1,2,3\n"), HasSubstr("is not a log of this program"));
  EXPECT_THAT(refusal_of_text("TRILOG2\n and more"), HasSubstr("another format than version 1"));
  EXPECT_THAT(refusal_of_text(""), HasSubstr("is not a log of this program"));
  EXPECT_THAT(refusal_of_text("TRILOG1\n"), HasSubstr("nothing was recorded in it"));
  EXPECT_THAT(message_of([&] { read_event_log(folder / "none.trilog", [](std::size_t, LogEvent&&) {}); }),
              HasSubstr("none.trilog: cannot be read"));
}

// Wherever a log is cut within its head, the head alone is refused as the log is.
TEST(EventLog, AHeadThatIsCutIsRefusedAndNotWaitedFor) {
  const ScratchFolder folder;
  { EventLogWriter log(folder / "a", head_with(header_of(2))); }
  const std::string bytes = read_file(folder / "a");
  ASSERT_EQ(head_of_event_log(folder / "a").session.sensors.size(), 2u);
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{5}, std::size_t{8}, std::size_t{20}, std::size_t{60}}) {
    ASSERT_LT(size, bytes.size());
    std::ofstream(folder / "cut", std::ios::binary) << bytes.substr(0, size);
    EXPECT_THAT(message_of([&] { head_of_event_log(folder / "cut"); }), HasSubstr("cut: ")) << size;
  }
}

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

// A damaged length must not make a reader wait for what never comes, nor for a megabyte of other records.
TEST(EventLog, WhatFollowsADamagedRecordHeadIsReadAtOnce) {
  const ScratchFolder folder;
  const auto texts = write_some(folder / "a.trilog");
  const auto bytes = bytes_of_file(folder / "a.trilog");
  std::uint32_t head_bytes = 0;
  std::memcpy(&head_bytes, bytes.data() + 8, sizeof head_bytes);
  const std::size_t head_end = 8 + 12 + head_bytes;
  const std::vector<std::pair<std::size_t, std::byte>> damages{
      {3, std::byte{0x7f}},  // length beyond any payload
      {4, std::byte{0}},     // type below the first
      {4, std::byte{99}},    // type behind the last
      {6, std::byte{0}}};    // sync
  for (const auto& [at, byte] : damages) {
    auto damaged = bytes;
    damaged.at(head_end + at) = byte;
    std::vector<std::string> read;
    LogScanner scanner("a.trilog",
                       [&](std::size_t sensor, LogEvent&& event) { read.push_back(text_of(sensor, event)); });
    scanner.feed(damaged);  // and no end
    EXPECT_EQ(read, std::vector<std::string>(texts.begin() + 1, texts.end())) << at;
  }
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

}  // namespace
}  // namespace trilat
