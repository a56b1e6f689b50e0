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

}  // namespace
}  // namespace trilat
