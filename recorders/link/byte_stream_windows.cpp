// SPDX-License-Identifier: MIT
#include <algorithm>
#include <system_error>
#include <thread>
#include <utility>

#include <winsock2.h>
#include <ws2tcpip.h>

#include "datasets/base/error.h"
#include "recorders/link/byte_stream.h"

namespace trilat {
namespace {

std::string reason_of(unsigned long code) { return std::system_category().message(static_cast<int>(code)); }

class SocketStream : public ByteStream {
 public:
  explicit SocketStream(SOCKET socket) : socket_(socket) {
    const DWORD on = 1, patience_ms = 5000;
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, reinterpret_cast<const char*>(&on), sizeof on);
    ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, reinterpret_cast<const char*>(&patience_ms),
                 sizeof patience_ms);
  }
  ~SocketStream() override { ::closesocket(socket_); }

  std::size_t read_some(std::span<std::byte> into, std::chrono::milliseconds at_most) override {
    fd_set watched;
    FD_ZERO(&watched);
    FD_SET(socket_, &watched);
    timeval limit{static_cast<long>(at_most.count() / 1000),
                  static_cast<long>(at_most.count() % 1000 * 1000)};
    if (::select(0, &watched, nullptr, nullptr, &limit) <= 0) return 0;
    const int count = ::recv(socket_, reinterpret_cast<char*>(into.data()),
                             static_cast<int>(std::min<std::size_t>(into.size(), 1 << 20)), 0);
    if (count == 0) throw LinkLost("closed by the other side");
    if (count < 0) throw LinkLost(reason_of(static_cast<unsigned long>(::WSAGetLastError())));
    return static_cast<std::size_t>(count);
  }
  void write_all(std::span<const std::byte> from) override {
    while (!from.empty()) {
      const int count = ::send(socket_, reinterpret_cast<const char*>(from.data()),
                               static_cast<int>(std::min<std::size_t>(from.size(), 1 << 20)), 0);
      if (count <= 0) throw LinkLost(reason_of(static_cast<unsigned long>(::WSAGetLastError())));
      from = from.subspan(static_cast<std::size_t>(count));
    }
  }

 private:
  SOCKET socket_;
};

struct Handle {
  HANDLE handle = nullptr;
  ~Handle() {
    if (handle) ::CloseHandle(handle);
  }
};

// Standard input and output of a child process.
class ProcessStream : public ByteStream {
 public:
  explicit ProcessStream(const std::vector<std::string>& words) {
    SECURITY_ATTRIBUTES inherited{sizeof inherited, nullptr, TRUE};
    Handle child_in, child_out;
    if (!::CreatePipe(&child_in.handle, &out_.handle, &inherited, 1 << 20) ||
        !::CreatePipe(&in_.handle, &child_out.handle, &inherited, 1 << 20))
      throw LinkLost("no pipe: " + reason_of(::GetLastError()));
    ::SetHandleInformation(out_.handle, HANDLE_FLAG_INHERIT, 0);
    ::SetHandleInformation(in_.handle, HANDLE_FLAG_INHERIT, 0);
    std::string line;
    for (const std::string& word : words) line += (line.empty() ? "" : " ") + quoted(word);
    STARTUPINFOA start{};
    start.cb = sizeof start;
    start.dwFlags = STARTF_USESTDHANDLES;
    start.hStdInput = child_in.handle;
    start.hStdOutput = child_out.handle;
    start.hStdError = ::GetStdHandle(STD_ERROR_HANDLE);
    PROCESS_INFORMATION process{};
    if (!::CreateProcessA(nullptr, line.data(), nullptr, nullptr, TRUE, CREATE_NEW_PROCESS_GROUP, nullptr,
                          nullptr, &start, &process))
      throw InputError(words[0], "cannot be run: " + reason_of(::GetLastError()));
    ::CloseHandle(process.hThread);
    child_.handle = process.hProcess;
  }
  ~ProcessStream() override {
    ::TerminateProcess(child_.handle, 0);
    ::WaitForSingleObject(child_.handle, 1000);
  }

  std::size_t read_some(std::span<std::byte> into, std::chrono::milliseconds at_most) override {
    constexpr std::chrono::milliseconds kPeekPeriod{5};
    for (auto left = at_most;; left -= kPeekPeriod) {
      DWORD there = 0;
      if (!::PeekNamedPipe(in_.handle, nullptr, 0, nullptr, &there, nullptr))
        throw LinkLost("its program has ended");
      DWORD count = 0;
      if (there > 0 &&
          ::ReadFile(in_.handle, into.data(), static_cast<DWORD>(std::min<std::size_t>(into.size(), there)),
                     &count, nullptr))
        return count;
      if (left < kPeekPeriod) return 0;
      std::this_thread::sleep_for(kPeekPeriod);
    }
  }
  void write_all(std::span<const std::byte> from) override {
    while (!from.empty()) {
      DWORD count = 0;
      if (!::WriteFile(out_.handle, from.data(),
                       static_cast<DWORD>(std::min<std::size_t>(from.size(), 1 << 16)), &count, nullptr))
        throw LinkLost("its program has ended");
      from = from.subspan(count);
    }
  }

 private:
  // Quotes a word as the C runtime of the child takes a line apart.
  static std::string quoted(const std::string& word) {
    if (!word.empty() && word.find_first_of(" \t\"") == std::string::npos) return word;
    std::string text = "\"";
    for (const char c : word) text += c == '"' ? "\\\"" : std::string(1, c);
    return text + '"';
  }
  Handle in_, out_, child_;
};

}  // namespace

std::unique_ptr<ByteStream> connect_loopback(const SocketAddress& address) {
  if (!is_loopback(address))
    throw InputError(
        text_of(address),
        "lies beyond this machine, and what is sent there would not be encrypted: use USER@HOST, "
        "which goes through SSH");
  static const int started = [] {
    WSADATA data;
    return ::WSAStartup(MAKEWORD(2, 2), &data);
  }();
  if (started != 0) throw LinkLost("Windows gives no sockets");
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found) != 0)
    throw InputError(text_of(address), "is not an address");
  std::string problem = "no address";
  for (const addrinfo* info = found; info; info = info->ai_next) {
    const SOCKET socket = ::socket(info->ai_family, info->ai_socktype, info->ai_protocol);
    if (socket != INVALID_SOCKET &&
        ::connect(socket, info->ai_addr, static_cast<int>(info->ai_addrlen)) == 0) {
      ::freeaddrinfo(found);
      return std::make_unique<SocketStream>(socket);
    }
    problem = reason_of(static_cast<unsigned long>(::WSAGetLastError()));
    if (socket != INVALID_SOCKET) ::closesocket(socket);
  }
  ::freeaddrinfo(found);
  throw LinkLost(text_of(address) + ": " + problem);
}

std::vector<std::string> shell_words(const std::string& line) { return {"cmd.exe", "/c", line}; }

std::unique_ptr<ByteStream> run_program(const std::vector<std::string>& words) {
  return std::make_unique<ProcessStream>(words);
}

}  // namespace trilat
