// SPDX-License-Identifier: MIT
#include <fstream>

#include <gmock/gmock.h>

#include "datasets/base/philox.h"
#include "recorders/link/byte_stream.h"
#include "recorders/link/messages.h"
#include "tests/recorders/pattern_source.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

std::vector<Message> every_message() {
  return {HelloMessage{LinkRole::clock, "left", 1, 2, 3},
          WelcomeMessage{4, 5},
          RefusalMessage{"is full", true},
          BytesMessage{6, 7, std::vector<std::byte>(300, std::byte{8})},
          LiveMessage{1, PatternSource::bodies_of(0, 2)},
          AckMessage{10, true},
          PingMessage{},
          PongMessage{-11, 12}};
}

// Messages as their bytes, which tell any two apart.
std::vector<std::vector<std::byte>> read_back(std::span<const std::byte> bytes, std::size_t piece) {
  MessageReader reader;
  std::vector<std::vector<std::byte>> read;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    reader.add(bytes.subspan(at, std::min(piece, bytes.size() - at)));
    while (const auto message = reader.next()) read.push_back(encode_message(*message));
  }
  return read;
}

TEST(Messages, AreReadBackHoweverTheirBytesCome) {
  std::vector<std::byte> bytes;
  std::vector<std::vector<std::byte>> sent;
  for (const Message& message : every_message()) {
    sent.push_back(encode_message(message));
    bytes.insert(bytes.end(), sent.back().begin(), sent.back().end());
  }
  for (const std::size_t piece : {1u, 13u, 4096u}) EXPECT_EQ(read_back(bytes, piece), sent) << piece;
  MessageReader reader;
  reader.add(encode_message(every_message()[0]));
  const auto hello = std::get<HelloMessage>(reader.next().value());
  EXPECT_EQ(hello.role, LinkRole::clock);
  EXPECT_EQ(hello.agent, "left");
  EXPECT_EQ(hello.recording, 3u);
}

TEST(Messages, OfAnotherVersionAreRefusedWithBothVersions) {
  const auto problem_of = [](std::vector<std::byte> bytes) -> std::string {
    MessageReader reader;
    reader.add(bytes);
    try {
      reader.next();
    } catch (const BadMessage& bad) {
      return bad.what();
    }
    return "none";
  };
  std::vector<std::byte> hello = encode_message(HelloMessage{});
  hello[9] = std::byte{4};  // behind the length, the type and the magic
  EXPECT_THAT(problem_of(hello),
              HasSubstr("speaks version 5 of the protocol, not 4: the agent is the older one"));
  hello[9] = std::byte{6};
  EXPECT_THAT(problem_of(hello), HasSubstr("not 6: the recorder is the older one"));
  hello[5] = std::byte{0};
  EXPECT_THAT(problem_of(hello), HasSubstr("does not speak trilat's protocol"));
  EXPECT_THAT(problem_of(std::vector<std::byte>(8, std::byte{0xff})), HasSubstr("too long"));
}

// 2,000 streams with a byte changed, cut or doubled: each gives messages or is refused.
TEST(Messages, WhateverComesIsReadOrRefused) {
  std::vector<std::byte> bytes;
  for (const Message& message : every_message()) {
    const auto more = encode_message(message);
    bytes.insert(bytes.end(), more.begin(), more.end());
  }
  std::size_t refused = 0;
  for (std::uint32_t trial = 0; trial < 2000; ++trial) {
    const RandomStream random{trial, Purpose::sensor_drop, 0};
    std::vector<std::byte> spoiled = bytes;
    for (std::uint32_t change = 0; change < 1 + trial % 12; ++change) {
      const auto at =
          static_cast<std::size_t>(random.uniform(2 * change) * static_cast<double>(spoiled.size()));
      spoiled.at(at) = static_cast<std::byte>(256.0 * random.uniform(2 * change + 1));
    }
    if (trial % 5 == 0) spoiled.resize(spoiled.size() / 2);
    try {
      read_back(spoiled, 64);
    } catch (const BadMessage&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 200u);
  EXPECT_LT(refused, 2000u);
}

std::string received(ByteStream& stream, std::size_t count) {
  std::string text;
  std::byte block[100];
  while (text.size() < count) {
    const std::size_t read = stream.read_some(block, milliseconds(100));
    text.append(reinterpret_cast<const char*>(block), read);
  }
  return text;
}

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

TEST(ByteStream, AProgramIsSpokenToByItsStandardInputAndOutput) {
  const auto cat = run_program(shell_words("cat"));
  cat->write_all(bytes_of("some bytes"));
  EXPECT_EQ(received(*cat, 10), "some bytes");
  const auto ends = run_program(shell_words("exit 3"));
  EXPECT_THROW(received(*ends, 1), LinkLost);
  EXPECT_THAT(message_of([] { run_program({"no-such-program"}); }),
              HasSubstr("no-such-program: cannot be run"));
}

TEST(ByteStream, ASocketOfThisUserLeadsToOneListener) {
  const ScratchFolder folder;
  const auto path = folder / "own" / "recorder";
  {
    StreamListener listener(path);
    EXPECT_EQ(std::filesystem::status(path.parent_path()).permissions(), std::filesystem::perms::owner_all);
    EXPECT_THAT(message_of([&] { StreamListener again(path); }),
                HasSubstr("is in use: another recording of this user"));
    const auto agent = connect_local(path);
    const auto recorder = [&] {
      auto accepted = listener.accept(milliseconds(1000));
      while (accepted) {  // the first one is the other listener's question
        agent->write_all(bytes_of("hello"));
        try {
          received(*accepted, 5);
          return accepted;
        } catch (const LinkLost&) {
          accepted = listener.accept(milliseconds(1000));
        }
      }
      return accepted;
    }();
    ASSERT_TRUE(recorder);
    recorder->write_all(bytes_of("welcome"));
    EXPECT_EQ(received(*agent, 7), "welcome");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_THROW(connect_local(path), LinkLost);
  std::filesystem::permissions(path.parent_path(), std::filesystem::perms(0755));
  EXPECT_THAT(message_of([&] { connect_local(path); }), HasSubstr("nobody else can enter"));
  EXPECT_THAT(message_of([&] { StreamListener listener(path); }), HasSubstr("nobody else can enter"));
  const std::filesystem::path file = path.parent_path() / "file";  // where a folder should be
  std::ofstream(file) << "x";
  std::filesystem::permissions(file, std::filesystem::perms(0600));
  EXPECT_THAT(message_of([&] { connect_local(file / "recorder"); }), HasSubstr("must be a folder"));
}

TEST(ByteStream, NothingIsListenedOnOrReachedBeyondThisMachine) {
  for (const char* address : {"0.0.0.0:0", "10.9.9.9:7345", "[::]:0", "example.org:7345"}) {
    EXPECT_THAT(message_of([&] { StreamListener listener(parse_address(address)); }),
                HasSubstr("use USER@HOST"));
    EXPECT_THAT(message_of([&] { connect_loopback(parse_address(address)); }), HasSubstr("use USER@HOST"));
  }
}

TEST(SocketAddress, IsReadAsAPersonWritesIt) {
  EXPECT_EQ(parse_address("127.0.0.1:7345").port, 7345);
  EXPECT_EQ(parse_address("[::1]:80").host, "::1");
  EXPECT_TRUE(is_loopback(parse_address("localhost:1")));
  EXPECT_TRUE(is_loopback(parse_address("127.3.2.1:1")));
  EXPECT_FALSE(is_loopback(parse_address("127.0.0.1.example.org:1")));
  for (const char* text : {"127.0.0.1", ":", "host:70000", "::1:80", "[::1:80", "::1]:80", "host:7x"})
    EXPECT_THAT(message_of([&] { parse_address(text); }), HasSubstr("must ")) << text;
}

}  // namespace
}  // namespace trilat
