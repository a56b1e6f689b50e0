// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "recorders/network/resend_ring.h"
#include "tests/recorders/network_rig.h"

namespace trilat {
namespace {

// What has arrived: frames by their sequence, and the last drop count.
struct Arrived {
  std::vector<std::int64_t> sequences;
  DropCount drops;
  bool bye = false;
  std::uint64_t next_number = 0;

  void take(const std::vector<std::byte>& bytes) {
    const auto decoded = decode_message(std::span<const std::byte>(bytes).subspan(kLengthBytes));
    const Message& message = std::get<Message>(decoded);
    if (const auto* last = std::get_if<ByeMessage>(&message)) {
      EXPECT_GE(last->number, next_number);
      next_number = last->number + 1;
      bye = true;
      return;
    }
    const auto& event = std::get<EventMessage>(message);
    EXPECT_GE(event.number, next_number);
    next_number = event.number + 1;
    if (const auto* frame = std::get_if<BodyFrame>(&event.data)) sequences.push_back(frame->stamp.sequence);
    if (const auto* depth = std::get_if<EncodedDepthFrame>(&event.data))
      sequences.push_back(depth->stamp.sequence);
    if (const auto* count = std::get_if<DropCount>(&event.data)) drops = *count;
  }
  void take_all(ResendRing& ring) {
    while (auto bytes = ring.next_to_send()) take(*bytes);
  }
};

SourceEvent empty_frame(std::size_t number) { return {0, BodyFrame{made_stamp(number), {}, {}}}; }

void push_frames(ResendRing& ring, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i) ring.push(empty_frame(i));
}

// An item of an empty frame costs 128 bytes and its message.
const std::size_t kFrameBytes = 128 + encode_message(EventMessage{0, 0, BodyFrame{}}).size();

TEST(ResendRing, SendsInOrderAndForgetsWhatIsAcknowledged) {
  ResendRing ring(1, 1 << 20, true);
  push_frames(ring, 0, 5);
  ring.push_bye();
  Arrived arrived;
  arrived.take_all(ring);
  EXPECT_THAT(arrived.sequences, testing::ElementsAre(0, 1, 2, 3, 4));
  EXPECT_TRUE(arrived.bye);
  EXPECT_FALSE(ring.empty());
  ring.acknowledge(arrived.next_number);
  EXPECT_TRUE(ring.empty());
  EXPECT_EQ(ring.bytes(), 0u);
}

TEST(ResendRing, ANewConnectionGetsWhatTheOtherSideLacks) {
  ResendRing ring(1, 1 << 20, true);
  push_frames(ring, 0, 10);
  Arrived arrived;
  for (int i = 0; i < 7; ++i) {
    const auto bytes = ring.next_to_send();
    if (i < 4) arrived.take(*bytes);
  }
  ring.resume(arrived.next_number);
  arrived.take_all(ring);
  EXPECT_THAT(arrived.sequences, testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_EQ(ring.lost_frames(), 0u);
}

TEST(ResendRing, WhatWasNeverSentAndDroppedIsLostAtOnce) {
  ResendRing ring(1, 10 * kFrameBytes, true);
  push_frames(ring, 0, 100);
  EXPECT_LE(ring.bytes(), 10 * kFrameBytes);
  Arrived arrived;
  arrived.take_all(ring);
  EXPECT_EQ(arrived.sequences.size() + ring.lost_frames(), 100u);
  EXPECT_EQ(arrived.sequences.back(), 99);
  EXPECT_EQ(arrived.drops.in_queue, static_cast<std::int64_t>(ring.lost_frames()));
}

TEST(ResendRing, WhatWasSentAndDroppedIsLostOnlyIfItDidNotArrive) {
  for (const std::size_t arrived_count : {0u, 3u, 8u}) {
    ResendRing ring(1, 8 * kFrameBytes, true);
    push_frames(ring, 0, 8);
    Arrived arrived;
    for (std::size_t i = 0; i < 8; ++i) {
      const auto bytes = ring.next_to_send();
      if (i < arrived_count) arrived.take(*bytes);
    }
    push_frames(ring, 8, 16);  // drops the first eight
    EXPECT_EQ(ring.lost_frames(), 0u);
    ring.resume(arrived.next_number);
    ring.push_bye();
    arrived.take_all(ring);
    EXPECT_EQ(arrived.sequences.size() + ring.lost_frames(), 16u) << arrived_count;
    EXPECT_EQ(ring.lost_frames(), 8 - arrived_count);
    EXPECT_EQ(arrived.drops.in_queue, static_cast<std::int64_t>(ring.lost_frames()));
    EXPECT_TRUE(arrived.bye);
  }
}

TEST(ResendRing, LossesFoundAfterTheByeAreStillTold) {
  ResendRing ring(1, 4 * kFrameBytes, true);
  push_frames(ring, 0, 4);
  while (ring.next_to_send()) {
  }
  push_frames(ring, 4, 8);
  ring.push_bye();
  while (ring.next_to_send()) {
  }
  ring.resume(0);
  Arrived arrived;
  arrived.take_all(ring);
  EXPECT_THAT(arrived.sequences, testing::ElementsAre(4, 5, 6, 7));
  EXPECT_EQ(arrived.drops.in_queue, 4);
  EXPECT_TRUE(arrived.bye);
  ring.acknowledge(arrived.next_number);
  EXPECT_TRUE(ring.empty());
}

TEST(ResendRing, PixelsAreSentInTheirPlaceOnceTheyAreCompressed) {
  ResendRing ring(1, 100 << 20, true);
  ring.push(empty_frame(0));
  ring.push({0, made_depth(1)});
  ring.push(empty_frame(2));
  Arrived arrived;
  arrived.take_all(ring);
  EXPECT_THAT(arrived.sequences, testing::ElementsAre(0));
  const auto pixels = ring.fetch_pixels();
  ASSERT_TRUE(pixels);
  EXPECT_FALSE(ring.fetch_pixels());
  const std::size_t before = ring.bytes();
  ring.put_compressed(pixels->first, encode_depth_frame(pixels->second.stamp, pixels->second.depth_mm,
                                                        ChunkCompression::blosc));
  EXPECT_LT(ring.bytes(), before);
  arrived.take_all(ring);
  EXPECT_THAT(arrived.sequences, testing::ElementsAre(0, 1, 2));
}

TEST(ResendRing, PixelsDroppedWhileTheyWereCompressedAreCountedOnce) {
  ResendRing ring(1, kDepthPixels * 2 + 1000, true);
  ring.push({0, made_depth(0)});
  const auto pixels = ring.fetch_pixels();
  ring.push({0, made_depth(1)});
  ring.put_compressed(pixels->first, {});
  EXPECT_EQ(ring.lost_frames(), 1u);
  EXPECT_FALSE(ring.empty());
}

TEST(ResendRing, ATornDepthFrameIsLeftOutAndCountedAsLostAtTheSource) {
  ResendRing ring(1, 100 << 20, true);
  ring.push({0, DropCount{1, 5, 0}});
  ring.push({0, DepthFrame{made_stamp(0), std::vector<std::uint16_t>(kDepthPixels - 1)}});
  ring.push({0, DepthFrame{made_stamp(1), {}}});
  EXPECT_FALSE(ring.fetch_pixels());
  Arrived arrived;
  arrived.take_all(ring);
  EXPECT_TRUE(arrived.sequences.empty());
  EXPECT_EQ(arrived.drops.at_source, 7);
  EXPECT_EQ(ring.lost_frames(), 0u);
}

TEST(ResendRing, PixelsThatCannotBeCompressedAreCountedAndHoldNothingUp) {
  ResendRing ring(1, 100 << 20, true);
  ring.push({0, made_depth(0)});
  push_frames(ring, 1, 2);
  ring.lose_pixels(ring.fetch_pixels()->first);
  Arrived arrived;
  arrived.take_all(ring);
  EXPECT_THAT(arrived.sequences, testing::ElementsAre(1));
  EXPECT_EQ(arrived.drops.in_queue, 1);
  ring.acknowledge(arrived.next_number);
  EXPECT_TRUE(ring.empty());
}

TEST(ResendRing, StartingOverForgetsWhatTheOtherSideLacksAndCountsAnew) {
  ResendRing ring(1, 10 * kFrameBytes, true);
  ring.push({0, DropCount{1, 5, 0}});
  push_frames(ring, 0, 12);
  Arrived before;
  before.take(*ring.next_to_send());
  const std::uint64_t lost = ring.lost_frames();
  EXPECT_EQ(lost + ring.start_over(), 12u);
  EXPECT_TRUE(ring.empty());
  ring.push({0, DropCount{2, 8, 0}});
  push_frames(ring, 20, 23);
  ring.resume(0);
  Arrived arrived;
  arrived.take_all(ring);
  EXPECT_THAT(arrived.sequences, testing::ElementsAre(20, 21, 22));
  EXPECT_EQ(arrived.drops.at_source, 3);
  EXPECT_EQ(arrived.drops.in_queue, 0);
}

TEST(ResendRing, WhatTheSourceLostItselfIsToldBesideWhatTheRingLost) {
  ResendRing ring(1, 10 * kFrameBytes, true);
  ring.push({0, DropCount{1, 5, 2}});
  push_frames(ring, 0, 30);
  Arrived arrived;
  arrived.take_all(ring);
  EXPECT_EQ(arrived.drops.at_source, 7);
  EXPECT_EQ(arrived.drops.in_queue, static_cast<std::int64_t>(ring.lost_frames()));
}

TEST(ResendRing, WithoutLeaveToDropItOnlySaysThatItIsFull) {
  ResendRing ring(1, 2 * kFrameBytes, false);
  push_frames(ring, 0, 1);
  EXPECT_FALSE(ring.full());
  push_frames(ring, 1, 9);
  EXPECT_TRUE(ring.full());
  EXPECT_EQ(ring.lost_frames(), 0u);
}

}  // namespace
}  // namespace trilat
