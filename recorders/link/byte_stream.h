// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace trilat {

// HOST:PORT, as a person writes it; an IPv6 address stands in brackets. An empty host means every address.
struct SocketAddress {
  std::string host;
  std::uint16_t port = 0;
};

// InputError naming `text` where it is not HOST:PORT.
SocketAddress parse_address(const std::string& text);

// Text of an address as parse_address() reads it.
std::string text_of(const SocketAddress& address);

// True for localhost and addresses that never leave this machine.
bool is_loopback(const SocketAddress& address);

// The connection is gone; another may succeed.
class LinkLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A two-way stream of bytes to one peer, whatever carries it. One thread.
class ByteStream {
 public:
  virtual ~ByteStream() = default;
  // Waits at most so long; how many bytes were read, 0 where none came. LinkLost when no more will come.
  virtual std::size_t read_some(std::span<std::byte> into, std::chrono::milliseconds at_most) = 0;
  // LinkLost when the other side is gone or takes nothing for five seconds.
  virtual void write_all(std::span<const std::byte> from) = 0;
};

// Makes a new stream to one fixed peer. LinkLost where that fails now, InputError where it always will.
using Connect = std::function<std::unique_ptr<ByteStream>()>;

// TCP to this machine. InputError for an address beyond it.
std::unique_ptr<ByteStream> connect_loopback(const SocketAddress& address);

// Standard input and output of a program, found as the shell finds it; it ends with the stream. InputError
// when there is no such program.
std::unique_ptr<ByteStream> run_program(const std::vector<std::string>& words);

// The words that make the system's shell run a line.
std::vector<std::string> shell_words(const std::string& line);

#ifndef _WIN32
// A socket in the file system, of this user alone.
std::unique_ptr<ByteStream> connect_local(const std::filesystem::path& path);

// Standard input and output of this process.
std::unique_ptr<ByteStream> standard_stream();

// Carries what each side says to the other until one ends.
void join_streams(ByteStream& a, ByteStream& b);

// Takes connections. One thread at a time.
class StreamListener {
 public:
  // On this machine; port 0 takes any free one. InputError for an address beyond it, or that cannot be had.
  explicit StreamListener(const SocketAddress& address);
  // On a socket in the file system; its folder is made for this user alone. InputError when another process
  // listens there.
  explicit StreamListener(const std::filesystem::path& path);
  ~StreamListener();
  StreamListener(const StreamListener&) = delete;
  StreamListener& operator=(const StreamListener&) = delete;

  std::uint16_t port() const { return port_; }
  // The next connection, or null when none came in time.
  std::unique_ptr<ByteStream> accept(std::chrono::milliseconds at_most);

 private:
  int socket_ = -1;
  std::uint16_t port_ = 0;
  std::filesystem::path path_;  // of a socket in the file system
};
#endif

}  // namespace trilat
