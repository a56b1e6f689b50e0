// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "recorders/network/wire.h"

namespace trilat {

// Cuts a stream of bytes into messages. Holds at most one message and what one add() brought. The first
// message has a limit of its own: a stranger gets little memory.
class MessageReader {
 public:
  void add(std::span<const std::byte> bytes);
  // The next complete message, or what is wrong, from where nothing more is read; nothing when more bytes are
  // needed.
  std::optional<std::variant<Message, WireError>> next();

 private:
  std::vector<std::byte> bytes_;
  std::size_t start_ = 0;
  bool first_ = true;
  bool broken_ = false;
};

}  // namespace trilat
