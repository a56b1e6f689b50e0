// SPDX-License-Identifier: MIT
#include "recorders/network/message_reader.h"

#include "recorders/network/wire_bytes.h"

namespace trilat {

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
