// SPDX-License-Identifier: MIT
#include "recorders/network/link/socket_link.h"

#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "datasets/base/error.h"

namespace trilat {
namespace {

struct Descriptor {
  int fd = -1;
  explicit Descriptor(int number) : fd(number) {}
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int release() { return std::exchange(fd, -1); }
};

std::string reason() { return std::strerror(errno); }

class SocketLink : public ByteLink {
 public:
  explicit SocketLink(int fd) : socket_(fd), wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    if (wake_.fd < 0) throw LinkLost("no more descriptors: " + reason());
    const int on = 1;
    ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  }

  std::size_t try_read(std::span<std::byte> into) override {
    const ssize_t count = ::recv(socket_.fd, into.data(), into.size(), 0);
    if (count == 0) throw LinkLost("closed by the other side");
    return counted(count);
  }
  std::size_t try_write(std::span<const std::byte> from) override {
    return counted(::send(socket_.fd, from.data(), from.size(), MSG_NOSIGNAL));
  }
  void wait(bool to_write, std::chrono::milliseconds at_most) override {
    const auto events = static_cast<short>(to_write ? POLLIN | POLLOUT : POLLIN);
    pollfd watched[] = {{socket_.fd, events, 0}, {wake_.fd, POLLIN, 0}};
    ::poll(watched, 2, static_cast<int>(at_most.count()));
    std::uint64_t woken = 0;
    if (watched[1].revents) [[maybe_unused]]
      const ssize_t taken = ::read(wake_.fd, &woken, sizeof woken);
  }
  void wake() override {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t put = ::write(wake_.fd, &one, sizeof one);
  }

 private:
  static std::size_t counted(ssize_t count) {
    if (count >= 0) return static_cast<std::size_t>(count);
    if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) return 0;
    throw LinkLost(reason());
  }
  Descriptor socket_;
  Descriptor wake_;
};

struct Addresses {
  addrinfo* first = nullptr;
  ~Addresses() {
    if (first) ::freeaddrinfo(first);
  }
};

void look_up(const SocketAddress& address, bool to_listen, Addresses& found) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV | (to_listen ? AI_PASSIVE : 0);
  const std::string port = std::to_string(address.port);
  const int code = ::getaddrinfo(address.host.empty() ? nullptr : address.host.c_str(), port.c_str(), &hints,
                                 &found.first);
  if (code == EAI_AGAIN)
    throw LinkLost(std::string("the name cannot be looked up now: ") + gai_strerror(code));
  if (code != 0)
    throw InputError(text_of(address), std::string("is not an address: ") + ::gai_strerror(code));
}

int open_socket(const addrinfo& info) {
  return ::socket(info.ai_family, info.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, info.ai_protocol);
}

// Zero where the connection stands, else the error.
int connect_within(int fd, const addrinfo& info, std::chrono::milliseconds at_most) {
  if (::connect(fd, info.ai_addr, info.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  pollfd watched{fd, POLLOUT, 0};
  if (::poll(&watched, 1, static_cast<int>(at_most.count())) <= 0) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

int listen_on(const addrinfo& info) {
  Descriptor fd(open_socket(info));
  if (fd.fd < 0) return -1;
  const int on = 1, off = 0;
  ::setsockopt(fd.fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (info.ai_family == AF_INET6) ::setsockopt(fd.fd, IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
  if (::bind(fd.fd, info.ai_addr, info.ai_addrlen) != 0 || ::listen(fd.fd, 128) != 0) return -1;
  return fd.release();
}

std::string host_text(const sockaddr_storage& from, socklen_t size) {
  char host[NI_MAXHOST] = "?";
  ::getnameinfo(reinterpret_cast<const sockaddr*>(&from), size, host, sizeof host, nullptr, 0,
                NI_NUMERICHOST);
  return host;
}

}  // namespace

std::unique_ptr<ByteLink> connect_socket(const SocketAddress& address, std::chrono::milliseconds at_most) {
  Addresses found;
  look_up(address, false, found);
  std::string problem = "no address";
  for (const addrinfo* info = found.first; info; info = info->ai_next) {
    Descriptor fd(open_socket(*info));
    const int error = fd.fd < 0 ? errno : connect_within(fd.fd, *info, at_most);
    if (error == 0) return std::make_unique<SocketLink>(fd.release());
    problem = std::strerror(error);
  }
  throw LinkLost(text_of(address) + ": " + problem);
}

SocketListener::SocketListener(const SocketAddress& address) {
  Addresses found;
  look_up(address, true, found);
  // an IPv6 socket for every address takes IPv4 as well
  for (const int family : {AF_INET6, AF_INET})
    for (const addrinfo* info = found.first; info && socket_ < 0; info = info->ai_next)
      if (info->ai_family == family) socket_ = listen_on(*info);
  if (socket_ < 0) throw InputError(text_of(address), "cannot be listened on: " + reason());
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  ::getsockname(socket_, reinterpret_cast<sockaddr*>(&bound), &size);
  port_ = ntohs(bound.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(bound).sin6_port
                                            : reinterpret_cast<sockaddr_in&>(bound).sin_port);
}

SocketListener::~SocketListener() {
  if (socket_ >= 0) ::close(socket_);
}

std::optional<SocketListener::Accepted> SocketListener::accept(std::chrono::milliseconds at_most) {
  pollfd watched{socket_, POLLIN, 0};
  if (::poll(&watched, 1, static_cast<int>(at_most.count())) <= 0) return std::nullopt;
  sockaddr_storage from{};
  socklen_t size = sizeof from;
  const int fd = ::accept4(socket_, reinterpret_cast<sockaddr*>(&from), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd < 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));  // as when there are no more descriptors
    return std::nullopt;
  }
  try {
    return Accepted{std::make_unique<SocketLink>(fd), host_text(from, size)};
  } catch (const LinkLost&) {
    return std::nullopt;
  }
}

}  // namespace trilat
