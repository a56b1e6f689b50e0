// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

namespace trilat {

// The connection is gone; another may succeed.
class LinkLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The other side is not one that we talk to, or does not talk to us: trying again changes nothing by itself.
class LinkRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A two-way stream of bytes to one peer, whatever carries it. All but wake() belong to one thread; none but
// wait() blocks.
class ByteLink {
 public:
  virtual ~ByteLink() = default;
  // How many bytes were read; 0: none now. Throws LinkLost when there will be no more.
  virtual std::size_t try_read(std::span<std::byte> into) = 0;
  // How many bytes were taken; 0: none now. Throws LinkLost.
  virtual std::size_t try_write(std::span<const std::byte> from) = 0;
  // Waits until bytes may be read, or written where `to_write`, or wake() was called, or the time is over.
  virtual void wait(bool to_write, std::chrono::milliseconds at_most) = 0;
  // Ends a wait(), now or the next. Any thread.
  virtual void wake() = 0;
  // The name that the peer has proved to bear; empty when nothing was proved.
  virtual std::string peer_name() const { return {}; }
};

// Makes a new connection to one fixed peer. Throws LinkLost or LinkRefused; InputError for a bad address.
using ConnectLink = std::function<std::unique_ptr<ByteLink>()>;

}  // namespace trilat
