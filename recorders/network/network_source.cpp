// SPDX-License-Identifier: MIT
#include "recorders/network/network_source.h"

#include <ctime>
#include <list>
#include <system_error>
#include <thread>
#include <utility>

#include "datasets/base/error.h"
#include "recorders/network/server_state.h"

namespace trilat {
namespace {

constexpr std::chrono::milliseconds kSourceLookPeriod{50};
constexpr std::chrono::milliseconds kCountLimit{1000};  // for connections to count what has not come

std::string utc_text() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

std::uint64_t recording_number() {
  return static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
}

void throw_if_broken(const std::vector<AgentBook::BrokenSource>& sources) {
  if (sources.empty()) return;
  std::string problem;
  for (const auto& [agent, why] : sources)
    problem += (problem.empty() ? "" : "; agent " + agent + ": ") + ("its source broke: " + why);
  throw InputError("agent " + sources.front().agent, problem);
}

void throw_if_unfinished(const std::vector<std::string>& agents) {
  if (agents.empty()) return;
  std::string names;
  for (const std::string& agent : agents) names += (names.empty() ? "" : ", ") + agent;
  throw InputError("agent " + names,
                   "has not sent all it held in the time after the recording was stopped; that is lost");
}

}  // namespace

// Takes connections and gives each a thread.
class NetworkSource::Listening {
 public:
  explicit Listening(ListenOptions options) : state(std::move(options)), listener_(state.options.address) {
    if (state.options.keys.empty() && !state.options.allow_plain_text && !is_loopback(state.options.address))
      throw InputError(state.options.address.host,
                       "plain text may only be spoken on this machine; give keys");
    state.recording = recording_number();
    acceptor_ = std::thread([this] { accept_all(); });
  }
  ~Listening() {
    state.stop = true;
    state.queue.close();
    acceptor_.join();
    for (Connection& connection : connections_) connection.thread.join();
  }

  std::uint16_t port() const { return listener_.port(); }

  // Agents send what they hold, for as long as they may. Before the recording has begun there is nothing.
  void drain() {
    if (!state.book.begun()) {
      state.stop = true;
      state.queue.close();
    } else if (!state.stopping.exchange(true)) {
      drain_end_ns_ = steady_now_ns() + std::chrono::nanoseconds(state.options.drain_limit).count();
    }
  }

  ServerState state;

 private:
  struct Connection {
    std::thread thread;
    std::atomic<bool> done{false};
  };

  void accept_all() {
    while (!state.stop) {
      try {
        auto accepted = listener_.accept(kSourceLookPeriod);
        join_done();
        end_drain();
        if (accepted) serve(std::move(*accepted));
      } catch (const std::exception& error) {
        state.refusals.add(std::string("a connection could not be taken: ") + error.what());
      }
    }
  }
  // First the connections count what has not come, then nothing more is taken.
  void end_drain() {
    const std::int64_t end_ns = drain_end_ns_;
    if (end_ns == 0 || steady_now_ns() < end_ns || state.queue.closed()) return;
    state.drain_is_over = true;
    if (steady_now_ns() < end_ns + std::chrono::nanoseconds(kCountLimit).count()) return;
    state.unfinished = state.book.unfinished();
    state.queue.close();
  }
  void join_done() {
    connections_.remove_if([](Connection& connection) {
      if (!connection.done) return false;
      connection.thread.join();
      return true;
    });
  }
  void serve(SocketListener::Accepted accepted) {
    const auto stranger = state.strangers.add(accepted.from, kSourceLookPeriod);
    Connection& connection = connections_.emplace_back();
    try {
      connection.thread =
          std::thread([this, &connection, stranger, link = std::move(accepted.link)]() mutable {
            try {
              serve_connection(state, std::move(link), stranger);
            } catch (...) {  // not even the refusal could be told
            }
            connection.done = true;
          });
    } catch (const std::system_error&) {
      connections_.pop_back();
      state.strangers.remove(stranger);
    }
  }

  std::atomic<std::int64_t> drain_end_ns_{0};
  SocketListener listener_;
  std::list<Connection> connections_;  // of the acceptor's thread, until that has ended
  std::thread acceptor_;
};

NetworkSource::NetworkSource(ListenOptions options)
    : listening_(std::make_unique<Listening>(std::move(options))) {}

NetworkSource::~NetworkSource() = default;

std::uint16_t NetworkSource::port() const { return listening_->port(); }

void NetworkSource::wait_for_agents(std::size_t count, std::chrono::milliseconds timeout,
                                    const std::function<bool()>& stop) {
  AgentBook& book = listening_->state.book;
  TRILAT_CHECK(count > 0 && !book.begun(), "agents are waited for once");
  const auto give_up = [&] { return stop() || listening_->state.stop.load(); };
  if (!book.begin(count, timeout, give_up)) {
    if (give_up()) throw Interrupted();
    std::string came;
    for (const std::string& name : book.names()) came += (came.empty() ? "" : ", ") + name;
    throw InputError("port " + std::to_string(port()),
                     std::to_string(count) + " agents were awaited, came: " + (came.empty() ? "none" : came));
  }
  header_.sensors = book.sensors();
  header_.simulated = book.simulated();
  header_.started_utc = utc_text();
}

const SessionHeader& NetworkSource::header() const {
  TRILAT_CHECK(!header_.sensors.empty(), "wait_for_agents() comes before header()");
  return header_;
}

std::optional<SourceEvent> NetworkSource::next() {
  if (auto event = listening_->state.queue.pop()) return event;
  if (!std::exchange(told_what_broke_, true)) {
    throw_if_broken(listening_->state.book.broken_sources());
    throw_if_unfinished(listening_->state.unfinished);
  }
  return std::nullopt;
}

void NetworkSource::stop() { listening_->drain(); }

}  // namespace trilat
