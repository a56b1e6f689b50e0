// SPDX-License-Identifier: MIT
#include "recorders/network/link/message_link.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
  (void)trilat::decode_message(bytes);
  trilat::MessageReader reader;
  reader.add(bytes);
  while (const auto message = reader.next()) {
    const auto* sound = std::get_if<trilat::Message>(&*message);
    if (sound) (void)trilat::encode_message(*sound);
  }
  return 0;
}
