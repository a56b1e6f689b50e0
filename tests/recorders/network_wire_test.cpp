// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/philox.h"
#include "recorders/network/link/message_link.h"
#include "recorders/network/link/wire.h"
#include "tests/recorders/network_rig.h"

namespace trilat {
namespace {

std::span<const std::byte> body_of(const std::vector<std::byte>& encoded) {
  return std::span<const std::byte>(encoded).subspan(kLengthBytes);
}

std::vector<Message> one_of_each() {
  HelloMessage hello{
      LinkRole::data, "k1", 0xfedcba9876543210u, true, MadeSource("kinect", {}).header().sensors, 31};
  EncodedDepthFrame depth{made_stamp(9), std::vector<std::byte>(300, std::byte{0xa5}),
                          ChunkCompression::deflate};
  return {hello,
          WelcomeMessage{7, 1u << 20},
          RefusalMessage{"no", true},
          ResumeMessage{12},
          EventMessage{5, 1, made_bodies(3)},
          EventMessage{6, 0, depth},
          EventMessage{7, 2, SourceNotice{"unplugged"}},
          EventMessage{8, 0, DropCount{0, 3, 4}},
          AckMessage{99},
          AliveMessage{},
          ClockPingMessage{4},
          ClockPongMessage{4, -5, 6},
          ByeMessage{100, "unplugged"}};
}

template <class T>
T round_trip(const T& message) {
  const auto decoded = decode_message(body_of(encode_message(message)));
  return std::get<T>(std::get<Message>(decoded));
}

TEST(Wire, EveryMessageComesBackAsItWas) {
  for (const Message& message : one_of_each()) {
    const auto encoded = encode_message(message);
    const auto decoded = decode_message(body_of(encoded));
    ASSERT_TRUE(std::holds_alternative<Message>(decoded)) << "message " << message.index();
    EXPECT_EQ(std::get<Message>(decoded).index(), message.index());
    EXPECT_EQ(encode_message(std::get<Message>(decoded)), encoded) << "message " << message.index();
  }
}

TEST(Wire, TrackingIdsStampsAndBitPatternsAreExact) {
  BodyFrame frame = made_bodies(1);
  frame.bodies[0].tracking_id = 0xffffffffffffffffu;
  frame.bodies[0].position_m[0] = {-0.0f, std::nanf("1"), 1e-42f};
  frame.stamp = {INT64_MIN, INT64_MAX, -1};
  const EventMessage event = round_trip(EventMessage{UINT64_MAX, 63, frame});
  const auto& back = std::get<BodyFrame>(event.data);
  EXPECT_EQ(event.number, UINT64_MAX);
  EXPECT_EQ(back.bodies[0].tracking_id, 0xffffffffffffffffu);
  EXPECT_EQ(back.stamp.sequence, INT64_MIN);
  EXPECT_EQ(back.stamp.device_ticks, INT64_MAX);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(std::bit_cast<std::uint32_t>(back.bodies[0].position_m[0][i]),
              std::bit_cast<std::uint32_t>(frame.bodies[0].position_m[0][i]));
}

TEST(Wire, BytesAreLittleEndianBehindALength) {
  const auto bytes = encode_message(ClockPingMessage{0x0102030405060708u});
  std::vector<int> numbers;
  for (const std::byte byte : bytes) numbers.push_back(std::to_integer<int>(byte));
  EXPECT_THAT(numbers, testing::ElementsAre(9, 0, 0, 0, 11, 8, 7, 6, 5, 4, 3, 2, 1));
}

TEST(Wire, TextsAreCutToTheirLimitAndCannotSteerATerminal) {
  const std::string text = "\x1b[2J" + std::string(5000, 'x') + "\n";
  const auto event = round_trip(EventMessage{0, 0, SourceNotice{text}});
  const std::string& back = std::get<SourceNotice>(event.data).text;
  EXPECT_EQ(back.size(), kMaxTextBytes);
  EXPECT_EQ(back.substr(0, 5), " [2Jx");
  auto encoded = encode_message(EventMessage{0, 0, SourceNotice{"ab"}});
  encoded.back() = std::byte{'\n'};
  EXPECT_TRUE(std::holds_alternative<WireError>(decode_message(body_of(encoded))));
}

TEST(Wire, EveryTruncationIsRefusedAndSoIsWhatStandsBehind) {
  for (const Message& message : one_of_each()) {
    auto encoded = encode_message(message);
    const bool open_ended = message.index() == Message(EventMessage{}).index() &&
                            std::holds_alternative<EncodedDepthFrame>(std::get<EventMessage>(message).data);
    const std::size_t least = open_ended ? 1 + 8 + 4 + 24 + 1 : body_of(encoded).size();
    for (std::size_t size = 0; size < least; ++size)
      EXPECT_TRUE(std::holds_alternative<WireError>(decode_message(body_of(encoded).first(size))))
          << "message " << message.index() << " cut to " << size;
    encoded.push_back(std::byte{0});
    EXPECT_EQ(std::holds_alternative<WireError>(decode_message(body_of(encoded))), !open_ended);
  }
}

TEST(Wire, AnotherVersionIsNamed) {
  auto encoded = encode_message(HelloMessage{});
  encoded[kLengthBytes + 5] = std::byte{9};
  EXPECT_THAT(std::get<WireError>(decode_message(body_of(encoded))).problem, testing::HasSubstr("version 9"));
}

TEST(MessageReader, BytesMayComeInPiecesOfAnySize) {
  std::vector<std::byte> stream;
  for (const Message& message : one_of_each()) {
    const auto encoded = encode_message(message);
    stream.insert(stream.end(), encoded.begin(), encoded.end());
  }
  for (const std::size_t piece : {1u, 3u, 7u, 1000u, 100000u}) {
    MessageReader reader;
    std::vector<std::size_t> kinds;
    for (std::size_t start = 0; start < stream.size(); start += piece) {
      reader.add(std::span<const std::byte>(stream).subspan(start, std::min(piece, stream.size() - start)));
      while (auto decoded = reader.next()) kinds.push_back(std::get<Message>(*decoded).index());
    }
    ASSERT_EQ(kinds.size(), one_of_each().size());
    for (std::size_t i = 0; i < kinds.size(); ++i) EXPECT_EQ(kinds[i], one_of_each()[i].index());
  }
}

TEST(MessageReader, AHugeLengthIsRefusedBeforeAnythingIsGathered) {
  for (const auto& [first, length] :
       {std::pair{true, kMaxFirstMessageBytes + 1}, {false, kMaxMessageBytes + 1}}) {
    MessageReader reader;
    if (!first) {
      reader.add(encode_message(AliveMessage{}));
      EXPECT_TRUE(std::holds_alternative<Message>(reader.next().value()));
    }
    std::vector<std::byte> bytes;
    for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::byte>(length >> (8 * i)));
    reader.add(bytes);
    EXPECT_TRUE(std::holds_alternative<WireError>(reader.next().value()));
    reader.add(encode_message(AliveMessage{}));
    EXPECT_FALSE(reader.next());
  }
}

}  // namespace
}  // namespace trilat
