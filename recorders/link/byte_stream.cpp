// SPDX-License-Identifier: MIT
#include "recorders/link/byte_stream.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <system_error>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "datasets/base/error.h"

namespace trilat {
namespace {

std::string reason() { return std::strerror(errno); }

struct Descriptor {
  int fd = -1;
  explicit Descriptor(int number = -1) : fd(number) {}
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
  Descriptor(Descriptor&& other) noexcept : fd(std::exchange(other.fd, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd, other.fd);
    return *this;
  }
};

// Bytes through descriptors, which may be one socket or two pipes, and the process at their other end.
class DescriptorStream : public ByteStream {
 public:
  DescriptorStream(Descriptor in, Descriptor out, pid_t child = -1)
      : in_(std::move(in)), out_(std::move(out)), child_(child) {
    for (const int fd : {in_.fd, out_.fd})
      if (fd >= 0) ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) | O_NONBLOCK);
  }
  ~DescriptorStream() override {
    if (child_ < 0) return;
    in_ = Descriptor();
    out_ = Descriptor();
    ::kill(child_, SIGTERM);
    for (int i = 0; i < 100 && ::waitpid(child_, nullptr, WNOHANG) == 0; ++i) {
      if (i == 50) ::kill(child_, SIGKILL);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  std::size_t read_some(std::span<std::byte> into, std::chrono::milliseconds at_most) override {
    pollfd watched{in_.fd, POLLIN, 0};
    if (::poll(&watched, 1, static_cast<int>(at_most.count())) <= 0) return 0;
    const ssize_t count = ::read(in_.fd, into.data(), into.size());
    if (count == 0) throw LinkLost("closed by the other side");
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    if (count < 0) throw LinkLost(reason());
    return static_cast<std::size_t>(count);
  }

  void write_all(std::span<const std::byte> from) override {
    constexpr int kPatience_ms = 5000;
    const int fd = out_.fd >= 0 ? out_.fd : in_.fd;
    while (!from.empty()) {
      const ssize_t count = out_.fd >= 0 ? ::write(fd, from.data(), from.size())
                                         : ::send(fd, from.data(), from.size(), MSG_NOSIGNAL);
      if (count > 0) from = from.subspan(static_cast<std::size_t>(count));
      if (count >= 0 || errno == EINTR) continue;
      if (errno != EAGAIN) throw LinkLost(reason());
      pollfd watched{fd, POLLOUT, 0};
      if (::poll(&watched, 1, kPatience_ms) == 0) throw LinkLost("the other side takes nothing");
    }
  }

 private:
  Descriptor in_, out_;  // out_ of a socket: none
  pid_t child_;
};

std::unique_ptr<ByteStream> socket_stream(Descriptor socket) {
  const int on = 1;
  ::setsockopt(socket.fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);  // of a local socket it says no
  return std::make_unique<DescriptorStream>(std::move(socket), Descriptor());
}

struct Addresses {
  addrinfo* first = nullptr;
  explicit Addresses(const SocketAddress& address) {
    if (!is_loopback(address))
      throw InputError(text_of(address),
                       "lies beyond this machine, and what is sent there would not be encrypted: use "
                       "USER@HOST, which goes through SSH");
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_NUMERICSERV;
    const int code =
        ::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &first);
    if (code != 0)
      throw InputError(text_of(address), std::string("is not an address: ") + ::gai_strerror(code));
  }
  ~Addresses() {
    if (first) ::freeaddrinfo(first);
  }
  Addresses(const Addresses&) = delete;
  Addresses& operator=(const Addresses&) = delete;
};

sockaddr_un local_address(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.string().size() >= sizeof address.sun_path)
    throw InputError(path.string(), "is too long a path for a socket");
  std::strcpy(address.sun_path, path.c_str());
  return address;
}

// InputError where somebody else could have put a socket of theirs there.
void check_private(const std::filesystem::path& folder) {
  struct stat found {};
  if (::lstat(folder.c_str(), &found) != 0) throw LinkLost(folder.string() + ": " + reason());
  if (!S_ISDIR(found.st_mode) || found.st_uid != ::getuid() || (found.st_mode & 077) != 0)
    throw InputError(
        folder.string(),
        "must be a folder of this user that nobody else can enter (chmod 700); else it is not trusted");
}

Descriptor connected_to(const sockaddr_un& address) {
  Descriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (socket.fd >= 0 &&
      ::connect(socket.fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return Descriptor();
  return socket;
}

}  // namespace

std::unique_ptr<ByteStream> connect_loopback(const SocketAddress& address) {
  const Addresses found(address);
  std::string problem = "no address";
  for (const addrinfo* info = found.first; info; info = info->ai_next) {
    Descriptor socket(::socket(info->ai_family, info->ai_socktype | SOCK_CLOEXEC, info->ai_protocol));
    if (socket.fd >= 0 && ::connect(socket.fd, info->ai_addr, info->ai_addrlen) == 0)
      return socket_stream(std::move(socket));
    problem = reason();
  }
  throw LinkLost(text_of(address) + ": " + problem);
}

std::vector<std::string> shell_words(const std::string& line) { return {"sh", "-c", line}; }

std::unique_ptr<ByteStream> run_program(const std::vector<std::string>& words) {
  int to_child[2], from_child[2], failure[2];
  if (::pipe2(to_child, O_CLOEXEC) != 0) throw LinkLost("no pipe: " + reason());
  Descriptor child_in(to_child[0]), out(to_child[1]);
  if (::pipe2(from_child, O_CLOEXEC) != 0) throw LinkLost("no pipe: " + reason());
  Descriptor in(from_child[0]), child_out(from_child[1]);
  if (::pipe2(failure, O_CLOEXEC) != 0) throw LinkLost("no pipe: " + reason());
  Descriptor failed(failure[0]), fails(failure[1]);
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = ::fork();
  if (child < 0) throw LinkLost("no process: " + reason());
  if (child == 0) {
    ::dup2(child_in.fd, STDIN_FILENO);
    ::dup2(child_out.fd, STDOUT_FILENO);
    ::setpgid(0, 0);  // Ctrl-C in the terminal is for the agent, which ends the link in its time
    ::execvp(arguments[0], arguments.data());
    const int code = errno;
    [[maybe_unused]] const ssize_t told = ::write(fails.fd, &code, sizeof code);
    ::_exit(127);
  }
  fails = Descriptor();
  int code = 0;
  auto stream = std::make_unique<DescriptorStream>(std::move(in), std::move(out), child);
  if (::read(failed.fd, &code, sizeof code) == sizeof code)
    throw InputError(words[0], std::string("cannot be run: ") + std::strerror(code));
  return stream;
}

std::unique_ptr<ByteStream> connect_local(const std::filesystem::path& path) {
  check_private(path.parent_path());
  Descriptor socket = connected_to(local_address(path));
  if (socket.fd < 0) throw LinkLost(path.string() + ": " + reason());
  return socket_stream(std::move(socket));
}

std::unique_ptr<ByteStream> standard_stream() {
  return std::make_unique<DescriptorStream>(Descriptor(::dup(STDIN_FILENO)),
                                            Descriptor(::dup(STDOUT_FILENO)));
}

void join_streams(ByteStream& a, ByteStream& b) {
  const auto carry = [](ByteStream& from, ByteStream& to, std::chrono::milliseconds wait) {
    std::byte block[1 << 16];
    const std::size_t count = from.read_some(block, wait);
    to.write_all(std::span<const std::byte>(block).first(count));
    return count;
  };
  try {
    for (std::size_t moved = 0;; moved = carry(b, a, std::chrono::milliseconds(0)))
      moved += carry(a, b, std::chrono::milliseconds(moved > 0 ? 0 : 2));
  } catch (const LinkLost&) {
  }
}

StreamListener::StreamListener(const SocketAddress& address) {
  const Addresses found(address);
  for (const addrinfo* info = found.first; info && socket_ < 0; info = info->ai_next) {
    Descriptor socket(::socket(info->ai_family, info->ai_socktype | SOCK_CLOEXEC, info->ai_protocol));
    const int on = 1;
    ::setsockopt(socket.fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (::bind(socket.fd, info->ai_addr, info->ai_addrlen) == 0 && ::listen(socket.fd, 128) == 0)
      socket_ = std::exchange(socket.fd, -1);
  }
  if (socket_ < 0) throw InputError(text_of(address), "cannot be listened on: " + reason());
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  ::getsockname(socket_, reinterpret_cast<sockaddr*>(&bound), &size);
  port_ = ntohs(bound.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(bound).sin6_port
                                            : reinterpret_cast<sockaddr_in&>(bound).sin_port);
}

StreamListener::StreamListener(const std::filesystem::path& path) : path_(path) {
  const sockaddr_un address = local_address(path);
  std::error_code ignored;
  std::filesystem::create_directories(path.parent_path().parent_path(), ignored);
  ::mkdir(path.parent_path().c_str(), 0700);
  check_private(path.parent_path());
  if (connected_to(address).fd >= 0)
    throw InputError(path.string(),
                     "is in use: another recording of this user waits for agents or takes them");
  ::unlink(path.c_str());  // of a process that was killed
  Descriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (::bind(socket.fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(socket.fd, 128) != 0)
    throw InputError(path.string(), "cannot be listened on: " + reason());
  socket_ = std::exchange(socket.fd, -1);
}

StreamListener::~StreamListener() {
  if (socket_ >= 0) ::close(socket_);
  if (!path_.empty()) ::unlink(path_.c_str());
}

std::unique_ptr<ByteStream> StreamListener::accept(std::chrono::milliseconds at_most) {
  pollfd watched{socket_, POLLIN, 0};
  if (::poll(&watched, 1, static_cast<int>(at_most.count())) <= 0) return nullptr;
  Descriptor socket(::accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC));
  if (socket.fd >= 0) return socket_stream(std::move(socket));
  std::this_thread::sleep_for(std::chrono::milliseconds(10));  // as when there are no more descriptors
  return nullptr;
}

}  // namespace trilat
