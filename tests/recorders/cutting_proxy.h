// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <list>
#include <thread>
#include <vector>

#include "recorders/network/link/socket_link.h"

namespace trilat {

// A bad network between agent and recording machine: forwards bytes, cuts the n-th connection once it has
// carried so many bytes, and may stand still.
class CuttingProxy {
 public:
  CuttingProxy(std::uint16_t target_port, std::vector<std::size_t> cut_after_bytes)
      : target_port_(target_port),
        cut_after_bytes_(std::move(cut_after_bytes)),
        listener_({"127.0.0.1", 0}),
        thread_([this] { run(); }) {}
  ~CuttingProxy() {
    ended_ = true;
    thread_.join();
  }
  std::uint16_t port() const { return listener_.port(); }
  std::size_t cuts() const { return cuts_; }
  void stall(bool still) { stalled_ = still; }
  void cut_all() { cut_all_ = true; }
  void refuse(bool on) { refusing_ = on; }

 private:
  struct Direction {
    ByteLink& from;
    ByteLink& to;
    std::vector<std::byte> waiting{};
  };
  struct Pair {
    std::unique_ptr<ByteLink> agent, server;
    std::size_t bytes_left;
    Direction up{*agent, *server}, down{*server, *agent};
  };

  void run() {
    while (!ended_) {
      if (auto accepted = listener_.accept(std::chrono::milliseconds(pairs_.empty() ? 5 : 0));
          accepted && !refusing_)
        connect(std::move(accepted->link));
      const bool moved = !stalled_ && forward_all();
      if (cut_all_.exchange(false)) {
        cuts_ += pairs_.size();
        pairs_.clear();
      }
      if (!moved) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  void connect(std::unique_ptr<ByteLink> agent) {
    const std::size_t limit =
        connections_ < cut_after_bytes_.size() ? cut_after_bytes_[connections_] : SIZE_MAX;
    ++connections_;
    try {
      auto server = connect_socket({"127.0.0.1", target_port_}, std::chrono::seconds(5));
      pairs_.emplace_back(std::move(agent), std::move(server), limit);
    } catch (const LinkLost&) {
    }
  }
  bool forward_all() {
    bool moved = false;
    for (auto pair = pairs_.begin(); pair != pairs_.end();) {
      bool alive = true;
      try {
        moved |= forward(pair->up, pair->bytes_left);
        moved |= forward(pair->down, pair->bytes_left);
        alive = pair->bytes_left > 0;
        cuts_ += !alive;
      } catch (const LinkLost&) {
        alive = false;
      }
      pair = alive ? std::next(pair) : pairs_.erase(pair);
    }
    return moved;
  }
  static bool forward(Direction& way, std::size_t& bytes_left) {
    if (way.waiting.empty()) {
      way.waiting.resize(std::min<std::size_t>(16384, bytes_left));
      way.waiting.resize(way.waiting.empty() ? 0 : way.from.try_read(way.waiting));
    }
    const std::size_t sent = way.waiting.empty() ? 0 : way.to.try_write(way.waiting);
    way.waiting.erase(way.waiting.begin(), way.waiting.begin() + static_cast<std::ptrdiff_t>(sent));
    bytes_left -= std::min(sent, bytes_left);
    return sent > 0;
  }

  std::uint16_t target_port_;
  std::vector<std::size_t> cut_after_bytes_;
  SocketListener listener_;
  std::list<Pair> pairs_;
  std::size_t connections_ = 0;
  std::atomic<std::size_t> cuts_{0};
  std::atomic<bool> stalled_{false}, cut_all_{false}, refusing_{false}, ended_{false};
  std::thread thread_;
};

}  // namespace trilat
