// SPDX-License-Identifier: MIT
#include "recorders/link/messages.h"

#include <algorithm>
#include <utility>

namespace trilat {
namespace {

constexpr std::uint32_t kLinkMagic = 0x4c495254;  // "TRIL": a stranger is recognised whatever it speaks
constexpr std::size_t kLengthBytes = 4;
constexpr std::uint8_t kHelloType = 1;

void pass(auto& bytes, Is<HelloMessage> auto& hello) {
  bytes.word(hello.role, LinkRole::clock);
  bytes.text(hello.agent, kMaxNameBytes);
  bytes.number(hello.run);
  bytes.number(hello.log);
  bytes.number(hello.recording);
}
void pass(auto& bytes, Is<WelcomeMessage> auto& welcome) {
  bytes.number(welcome.recording);
  bytes.number(welcome.offset);
}
void pass(auto& bytes, Is<RefusalMessage> auto& refusal) {
  bytes.flag(refusal.try_again);
  bytes.text(refusal.reason, kMaxTextBytes);
}
void pass(auto& bytes, Is<BytesMessage> auto& sent) {
  bytes.number(sent.offset);
  bytes.number(sent.frames);
  bytes.rest(sent.bytes);
}
void pass(auto& bytes, Is<LiveMessage> auto& live) {
  bytes.number(live.sensor);
  pass(bytes, live.frame);
}
void pass(auto& bytes, Is<AckMessage> auto& ack) {
  bytes.number(ack.synced);
  bytes.flag(ack.stop);
}
void pass(auto&, Is<PingMessage> auto&) {}
void pass(auto& bytes, Is<PongMessage> auto& pong) {
  bytes.number(pong.received_ns);
  bytes.number(pong.sent_ns);
}

// The message of a type, a number from 1 by its place in the variant.
template <std::size_t index = 0>
Message message_of_type(std::uint8_t type) {
  if constexpr (index + 1 < std::variant_size_v<Message>)
    if (type != index + 1) return message_of_type<index + 1>(type);
  return Message(std::in_place_index<index>);
}

Message decode(std::span<const std::byte> body) {
  ByteReader in(body);
  const auto type = in.get<std::uint8_t>();
  if (type == kHelloType) {
    if (in.get<std::uint32_t>() != kLinkMagic) throw BadMessage("does not speak trilat's protocol");
    const auto version = in.get<std::uint16_t>();
    if (!in.failed() && version != kLinkVersion)
      throw BadMessage("the recorder speaks version " + std::to_string(kLinkVersion) +
                       " of the protocol, not " + std::to_string(version) + ": the " +
                       (version < kLinkVersion ? "agent" : "recorder") +
                       " is the older one; install the same version on both");
  }
  const bool known = type > 0 && type <= std::variant_size_v<Message>;
  Message message = message_of_type(type);
  Get get{in};
  std::visit([&](auto& m) { pass(get, m); }, message);
  if (!known || in.failed() || in.left() != 0)
    throw BadMessage("a message of type " + std::to_string(type) + " is damaged");
  return message;
}

}  // namespace

std::vector<std::byte> encode_message(const Message& message) {
  ByteWriter out;
  out.put(std::uint32_t{0});
  out.put(static_cast<std::uint8_t>(message.index() + 1));
  if (std::holds_alternative<HelloMessage>(message)) {
    out.put(kLinkMagic);
    out.put(kLinkVersion);
  }
  Put put{out};
  std::visit([&](const auto& m) { pass(put, m); }, message);
  std::vector<std::byte> bytes = out.take();
  const std::size_t length = bytes.size() - kLengthBytes;
  TRILAT_CHECK(length <= kMaxMessageBytes, "a message of ours fits the limit");
  for (std::size_t i = 0; i < kLengthBytes; ++i) bytes[i] = static_cast<std::byte>(length >> (8 * i));
  return bytes;
}

std::optional<Message> MessageReader::next() {
  const auto rest = std::span<const std::byte>(bytes_).subspan(taken_);
  if (rest.size() >= kLengthBytes) {
    ByteReader in(rest);
    const auto length = in.get<std::uint32_t>();
    if (length > kMaxMessageBytes) throw BadMessage("a message is too long");
    if (rest.size() - kLengthBytes >= length) {
      taken_ += kLengthBytes + length;
      return decode(rest.subspan(kLengthBytes, length));
    }
  }
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(std::exchange(taken_, 0)));
  return std::nullopt;
}

}  // namespace trilat
