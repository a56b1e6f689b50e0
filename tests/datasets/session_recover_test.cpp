// SPDX-License-Identifier: MIT
// Sessions that a recorder of version 0.4.0 left unfinished.
#include "datasets/session/session_recover.h"

#include <fstream>

#include <gmock/gmock.h>

#include "datasets/session/session_reader.h"
#include "datasets/session/session_writer.h"
#include "tests/datasets/made_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

// `pattern`, once in the file, with one bit changed.
void flip_a_bit_of(const std::filesystem::path& path, const std::string& pattern) {
  std::string bytes = read_file(path);
  const std::size_t at = bytes.find(pattern);
  ASSERT_NE(at, std::string::npos);
  bytes[at] = static_cast<char>(bytes[at] ^ 1);
  std::ofstream(path, std::ios::binary) << bytes;
}

TEST(SessionRecover, AnUnfinishedFileIsReadAsFarAsItsRecorderSaidThatItWasFlushed) {
  const ScratchFolder folder;
  SessionWriter writer(folder / "session.h5", header_of(1, true));
  for (std::int64_t i = 0; i < 8; ++i) {
    writer.add_body_frame(0, body_frame_of(i, 1));
    writer.add_depth_frame(0, encode_depth_frame({i, i, i}, depth_of(1), ChunkCompression::blosc));
  }
  writer.finish();
  const SessionReader session(killed_by_0_4(folder / "session.h5", 7, 5));
  EXPECT_FALSE(session.complete());
  EXPECT_EQ(session.counts(0).body_frames, 7u);
  EXPECT_EQ(session.counts(0).depth_frames, 5u);
  EXPECT_EQ(session.body_frames(0, 6, 1)[0].bodies.at(0).position_m,
            body_frame_of(6, 1).bodies[0].position_m);
}

TEST(SessionRecover, DamagedDepthIsLeftOutAndCounted) {
  const ScratchFolder folder;
  SessionWriter writer(folder / "session.h5", header_of(1, true));
  for (std::int64_t i = 0; i < 4; ++i) {
    EncodedDepthFrame frame =
        encode_depth_frame({i, i, i}, depth_of(static_cast<std::uint16_t>(i)), ChunkCompression::blosc);
    if (i == 2) frame.chunk[frame.chunk.size() / 2] ^= std::byte{1};
    writer.add_depth_frame(0, frame);
    writer.add_notice(0, {i, "notice " + std::to_string(i)});
  }
  writer.finish();
  const auto recoveries = recover_session(killed_by_0_4(folder / "session.h5", 0, 4), folder / "saved.h5");
  ASSERT_EQ(recoveries.size(), 1u);
  EXPECT_EQ(recoveries[0].damaged_depth_frames, 1u);
  EXPECT_EQ(recoveries[0].saved.depth_frames, 3u);
  const SessionReader session(folder / "saved.h5");
  EXPECT_TRUE(session.complete());
  EXPECT_EQ(session.stamps(0, FrameStream::depth, 0, 3)[2].sequence, 3);
  EXPECT_EQ(session.notices(0).size(), 5u);
  EXPECT_EQ(session.notices(0)[3].text, "notice 3");
  EXPECT_THAT(session.notices(0)[4].text, HasSubstr("0 body frames, 1 depth frames, 0 clock exchanges"));
}

TEST(SessionRecover, WhatIsDamagedCostsNoMoreThanItself) {
  const ScratchFolder folder;
  constexpr float kMark = 7.654321f;
  {
    SessionWriter writer(folder / "session.h5", header_of(2));
    for (std::int64_t i = 0; i < 600; ++i) {
      BodyFrame frame = body_frame_of(i, 1);
      if (i == 5) frame.bodies[0].position_m[3][2] = kMark;
      writer.add_body_frame(0, frame);
      BodyFrame late = body_frame_of(i, 1);
      if (i == 70) late.stamp.device_ticks = std::int64_t{1} << 62;
      writer.add_body_frame(1, late);
      const std::int64_t t2 = i == 50 ? std::int64_t{1} << 61 : i + 1;
      writer.add_clock_exchange(0, {i, t2, t2, i + 2});
    }
    writer.finish();
  }
  const auto partial = killed_by_0_4(folder / "session.h5", 600, 0);
  flip_a_bit_of(partial, std::string(reinterpret_cast<const char*>(&kMark), sizeof kMark));
  // a read that also touches the last chunk must not believe the damaged one
  EXPECT_THAT(message_of([&] { SessionReader(partial).body_frames(0, 0, 600); }),
              HasSubstr("position_m: cannot be read"));
  const auto recoveries = recover_session(partial, folder / "saved.h5");
  ASSERT_EQ(recoveries.size(), 2u);
  EXPECT_EQ(recoveries[0].damaged_body_frames, 256u);  // a chunk
  EXPECT_EQ(recoveries[0].damaged_exchanges, 1u);
  EXPECT_EQ(recoveries[1].damaged_body_frames, 1u);  // with an impossible time
  const SessionReader session(folder / "saved.h5");
  EXPECT_EQ(session.counts(0).body_frames, 344u);
  EXPECT_EQ(session.counts(0).bodies, 344u);
  EXPECT_EQ(session.counts(0).clock_exchanges, 599u);
  EXPECT_EQ(session.counts(1).body_frames, 599u);
  EXPECT_EQ(session.body_frames(0, 0, 1)[0].stamp.sequence, 256);
}

TEST(SessionRecover, CountsAndNoticesThatCannotBeReadAreCountedAsDamaged) {
  const ScratchFolder folder;
  std::string counts;  // of the second 256 frames
  {
    SessionWriter writer(folder / "session.h5", header_of(1));
    for (std::int64_t i = 0; i < 600; ++i) {
      const auto bodies = static_cast<int>(i * i % 7 % 4);
      if (i >= 256 && i < 512) counts += static_cast<char>(bodies);
      writer.add_body_frame(0, body_frame_of(i, static_cast<std::size_t>(bodies)));
      writer.add_notice(0, {i, "what was seen at " + std::to_string(1000 + i)});
    }
    writer.finish();
  }
  const auto partial = killed_by_0_4(folder / "session.h5", 2000, 0);
  flip_a_bit_of(partial, counts);
  flip_a_bit_of(partial, "what was seen at 1001");
  const auto recoveries = recover_session(partial, folder / "saved.h5");
  EXPECT_EQ(recoveries.at(0).saved.body_frames, 256u);
  EXPECT_EQ(recoveries[0].damaged_body_frames, 344u);  // what lies behind unknown counts, too
  EXPECT_EQ(recoveries[0].damaged_lists, 1u);
  EXPECT_THAT(SessionReader(folder / "saved.h5").notices(0).back().text,
              HasSubstr("344 body frames, 0 depth frames, 0 clock exchanges, 1 lists"));
}

}  // namespace
}  // namespace trilat
