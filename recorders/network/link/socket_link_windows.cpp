// SPDX-License-Identifier: MIT
#include <algorithm>
#include <limits>
#include <system_error>
#include <utility>

#include <winsock2.h>
#include <ws2tcpip.h>

#include "datasets/base/error.h"
#include "recorders/network/link/socket_link.h"

namespace trilat {
namespace {

std::string reason_of(int code) { return std::system_category().message(code); }

// Winsock, for as long as the process lives.
void start_winsock() {
  static const int code = [] {
    WSADATA data;
    return ::WSAStartup(MAKEWORD(2, 2), &data);
  }();
  if (code != 0) throw LinkLost("Windows gives no sockets: " + reason_of(code));
}

struct Socket {
  SOCKET handle = INVALID_SOCKET;
  explicit Socket(SOCKET opened) : handle(opened) {}
  ~Socket() {
    if (handle != INVALID_SOCKET) ::closesocket(handle);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  SOCKET release() { return std::exchange(handle, INVALID_SOCKET); }
};

struct Event {
  WSAEVENT handle = ::WSACreateEvent();
  Event() {
    if (handle == WSA_INVALID_EVENT) throw LinkLost("no more events: " + reason_of(::WSAGetLastError()));
  }
  ~Event() { ::WSACloseEvent(handle); }
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
};

class SocketLink : public ByteLink {
 public:
  explicit SocketLink(SOCKET connected) : socket_(connected) {
    const DWORD on = 1;
    ::setsockopt(connected, IPPROTO_TCP, TCP_NODELAY, reinterpret_cast<const char*>(&on), sizeof on);
    if (::WSAEventSelect(connected, ready_.handle, FD_READ | FD_WRITE | FD_CLOSE) != 0)
      throw LinkLost(reason_of(::WSAGetLastError()));
  }

  std::size_t try_read(std::span<std::byte> into) override {
    const int count = ::recv(socket_.handle, reinterpret_cast<char*>(into.data()), limited(into.size()), 0);
    if (count == 0) throw LinkLost("closed by the other side");
    return counted(count);
  }
  std::size_t try_write(std::span<const std::byte> from) override {
    const int count =
        ::send(socket_.handle, reinterpret_cast<const char*>(from.data()), limited(from.size()), 0);
    write_blocked_ = count < 0;
    return counted(count);
  }
  // Windows tells of room only after a write that found none.
  void wait(bool to_write, std::chrono::milliseconds at_most) override {
    if (to_write && !write_blocked_) return;
    const WSAEVENT watched[] = {ready_.handle, wake_.handle};
    const DWORD first =
        ::WSAWaitForMultipleEvents(2, watched, FALSE, static_cast<DWORD>(at_most.count()), FALSE);
    if (first == WSA_WAIT_EVENT_0) {
      WSANETWORKEVENTS happened;
      ::WSAEnumNetworkEvents(socket_.handle, ready_.handle, &happened);
    } else if (first == WSA_WAIT_EVENT_0 + 1) {
      ::WSAResetEvent(wake_.handle);
    }
  }
  void wake() override { ::WSASetEvent(wake_.handle); }

 private:
  static int limited(std::size_t size) {
    return static_cast<int>(std::min<std::size_t>(size, std::numeric_limits<int>::max()));
  }
  static std::size_t counted(int count) {
    if (count >= 0) return static_cast<std::size_t>(count);
    const int code = ::WSAGetLastError();
    if (code == WSAEWOULDBLOCK) return 0;
    throw LinkLost(reason_of(code));
  }
  Socket socket_;
  Event ready_, wake_;
  bool write_blocked_ = false;
};

// Zero where the connection stands, else the error.
int connect_within(SOCKET socket, const addrinfo& info, std::chrono::milliseconds at_most) {
  u_long nonblocking = 1;
  ::ioctlsocket(socket, FIONBIO, &nonblocking);
  if (::connect(socket, info.ai_addr, static_cast<int>(info.ai_addrlen)) == 0) return 0;
  if (::WSAGetLastError() != WSAEWOULDBLOCK) return ::WSAGetLastError();
  fd_set connected, refused;
  FD_ZERO(&connected);
  FD_ZERO(&refused);
  FD_SET(socket, &connected);
  FD_SET(socket, &refused);
  timeval limit{static_cast<long>(at_most.count() / 1000), static_cast<long>(at_most.count() % 1000 * 1000)};
  if (::select(0, nullptr, &connected, &refused, &limit) <= 0) return WSAETIMEDOUT;
  int error = 0, size = sizeof error;
  ::getsockopt(socket, SOL_SOCKET, SO_ERROR, reinterpret_cast<char*>(&error), &size);
  return error;
}

struct Addresses {
  addrinfo* first = nullptr;
  ~Addresses() {
    if (first) ::freeaddrinfo(first);
  }
};

}  // namespace

std::unique_ptr<ByteLink> connect_socket(const SocketAddress& address, std::chrono::milliseconds at_most) {
  start_winsock();
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  Addresses found;
  const int code =
      ::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found.first);
  if (code == WSATRY_AGAIN) throw LinkLost("the name cannot be looked up now: " + reason_of(code));
  if (code != 0) throw InputError(text_of(address), "is not an address: " + reason_of(code));
  std::string problem = "no address";
  for (const addrinfo* info = found.first; info; info = info->ai_next) {
    Socket socket(::socket(info->ai_family, info->ai_socktype, info->ai_protocol));
    const int error =
        socket.handle == INVALID_SOCKET ? ::WSAGetLastError() : connect_within(socket.handle, *info, at_most);
    if (error == 0) return std::make_unique<SocketLink>(socket.release());
    problem = reason_of(error);
  }
  throw LinkLost(text_of(address) + ": " + problem);
}

}  // namespace trilat
