// SPDX-License-Identifier: MIT
// What a stranger may send to a machine that listens, or a file of keys may hold: the first byte chooses
// between a file of keys, the recording machine's side of a handshake and an agent's.
#include <algorithm>

#include "recorders/network/link/socket_address.h"
#include "recorders/network/link/tls_keys.h"
#include "recorders/network/link/tls_link.h"
#include "tests/fuzz/fuzz_folder.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/tolerate_bad_input.h"

namespace trilat {
namespace {

// A peer that says these bytes, whatever it hears, and goes.
class TalkingPeer : public ByteLink {
 public:
  explicit TalkingPeer(std::span<const std::uint8_t> bytes) : left_(std::as_bytes(bytes)) {}
  std::size_t try_read(std::span<std::byte> into) override {
    if (left_.empty()) throw LinkLost("the peer has gone");
    const std::size_t count = std::min(into.size(), left_.size());
    std::copy_n(left_.begin(), count, into.begin());
    left_ = left_.subspan(count);
    return count;
  }
  std::size_t try_write(std::span<const std::byte> from) override { return from.size(); }
  void wait(bool, std::chrono::milliseconds) override {}
  void wake() override {}

 private:
  std::span<const std::byte> left_;
};

void shake_hands(TlsSide side, std::span<const std::uint8_t> bytes) {
  static const FuzzFolder folder("tls");
  static const auto made = make_tls_keys(folder.path(), {"k1", "k2"});
  static const TlsKeys server = read_tls_keys(folder.path() / "recorder.keys"),
                       agent = read_tls_keys(made[0]);
  try {
    const auto link = secure_link(std::make_unique<TalkingPeer>(bytes),
                                  side == TlsSide::server ? server : agent, side, std::chrono::seconds(1));
    std::byte block[4096];
    while (link->try_read(block) > 0) {
    }
  } catch (const LinkLost&) {
  } catch (const LinkRefused&) {
  }
}

void read_keys(std::span<const std::uint8_t> bytes) {
  const MemoryFile file(bytes);
  tolerate_bad_input([&] { read_tls_keys(file.path()); });
}

void read_address(std::span<const std::uint8_t> bytes) {
  tolerate_bad_input([&] {
    const SocketAddress address = parse_address(std::string(bytes.begin(), bytes.end()));
    is_loopback(address);
    parse_address(text_of(address));
  });
}

}  // namespace
}  // namespace trilat

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trilat;
  if (size == 0) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  if (data[0] % 4 == 0) read_keys(bytes);
  if (data[0] % 4 == 1) shake_hands(TlsSide::server, bytes);
  if (data[0] % 4 == 2) shake_hands(TlsSide::agent, bytes);
  if (data[0] % 4 == 3) read_address(bytes);
  return 0;
}
