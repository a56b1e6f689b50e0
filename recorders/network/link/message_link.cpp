// SPDX-License-Identifier: MIT
#include "recorders/network/link/message_link.h"

#include "recorders/network/link/wire.h"

namespace trilat {
namespace {

constexpr std::size_t kBlockBytes = 64u << 10;
constexpr std::size_t kMaxOutgoing = 4096;  // messages; who lets more pile up does not read
constexpr std::chrono::seconds kLifePeriod{1};

}  // namespace

MessageLink::MessageLink(std::unique_ptr<ByteLink> link, std::chrono::milliseconds silence_limit)
    : link_(std::move(link)), silence_limit_(silence_limit), block_(kBlockBytes) {}

void MessageLink::send(Bytes encoded) {
  if (outgoing_.size() >= kMaxOutgoing) throw LinkLost("the other side does not read");
  outgoing_.push_back(std::move(encoded));
  last_sent_ = Clock::now();
  flush();
}

void MessageLink::send(const Message& message) {
  send(std::make_shared<const std::vector<std::byte>>(encode_message(message)));
}

void MessageLink::send_sign_of_life(const Message& message) {
  if (Clock::now() - last_sent_ >= kLifePeriod) send(message);
}

void MessageLink::flush() {
  while (!outgoing_.empty()) {
    const auto rest = std::span<const std::byte>(*outgoing_.front()).subspan(outgoing_start_);
    const std::size_t taken = link_->try_write(rest);
    if (taken == 0) return;
    outgoing_start_ += taken;
    if (taken < rest.size()) continue;
    outgoing_.pop_front();
    outgoing_start_ = 0;
  }
}

std::optional<Message> MessageLink::receive() {
  flush();
  for (;;) {
    if (auto decoded = reader_.next()) {
      if (const auto* error = std::get_if<WireError>(&*decoded)) throw LinkRefused(error->problem);
      return std::get<Message>(std::move(*decoded));
    }
    const std::size_t count = link_->try_read(block_);
    if (count > 0) {
      last_heard_ = Clock::now();
      reader_.add(std::span<const std::byte>(block_).first(count));
    } else if (Clock::now() - last_heard_ > silence_limit_) {
      throw LinkLost("nothing was heard for " + std::to_string(silence_limit_.count()) + " ms");
    } else {
      return std::nullopt;
    }
  }
}

void MessageLink::wait(std::chrono::milliseconds at_most) { link_->wait(sending(), at_most); }

void MessageReader::add(std::span<const std::byte> bytes) {
  if (broken_) return;
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(start_));
  start_ = 0;
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

std::optional<std::variant<Message, WireError>> MessageReader::next() {
  const std::span<const std::byte> rest = std::span<const std::byte>(bytes_).subspan(start_);
  if (broken_ || rest.size() < kLengthBytes) return std::nullopt;
  const auto length = ByteReader(rest).get<std::uint32_t>();
  if (length > (first_ ? kMaxFirstMessageBytes : kMaxMessageBytes)) {
    broken_ = true;
    return WireError{"a message of " + std::to_string(length) + " bytes is announced"};
  }
  if (rest.size() - kLengthBytes < length) return std::nullopt;
  auto decoded = decode_message(rest.subspan(kLengthBytes, length));
  first_ = false;
  start_ += kLengthBytes + length;
  broken_ = std::holds_alternative<WireError>(decoded);
  return decoded;
}

}  // namespace trilat
