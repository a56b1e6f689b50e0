// SPDX-License-Identifier: MIT
#include "tests/recorders/link_torture.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <set>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "datasets/base/files.h"
#include "datasets/base/philox.h"
#include "datasets/session/session_reader.h"
#include "recorders/agent/run_agent.h"
#include "recorders/capture.h"
#include "tests/recorders/pattern_source.h"

namespace trilat {
namespace {

using std::chrono::milliseconds;

constexpr double kRate_hz = 100.0;

// Numbers that the processes of a trial share.
struct Shared {
  std::atomic<std::int64_t> start_ns{0}, first{-1}, made{0};  // of the sensor, which outlives its agent
};

// A sensor that makes a frame of bodies every 10 ms whether an agent takes it or not; its number says when.
class EternalSource : public FrameSource {
 public:
  EternalSource(Shared& shared, std::int64_t frames) : shared_(shared), frames_(frames) {
    SensorDescription sensor;
    sensor.name = "kinect";
    sensor.nominal_rate_hz = kRate_hz;
    header_.sensors = {sensor};
    std::int64_t none = 0;
    shared_.start_ns.compare_exchange_strong(none, host_now_ns());
  }
  const SessionHeader& header() const override { return header_; }
  bool live() const override { return true; }
  void stop() override { stopped_ = true; }
  std::optional<SourceEvent> next() override {
    const auto period_ns = static_cast<std::int64_t>(1e9 / kRate_hz);
    if (frame_ < 0) {
      frame_ = (host_now_ns() - shared_.start_ns) / period_ns + 1;
      frames_ = std::max(frames_, frame_ + 50);  // also of an agent that is started again late
      std::int64_t none = -1;
      shared_.first.compare_exchange_strong(none, frame_);
    }
    while (!stopped_ && host_now_ns() < shared_.start_ns + frame_ * period_ns)
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    if (stopped_ || frame_ >= frames_) return std::nullopt;
    BodyFrame frame = PatternSource::bodies_of(0, frame_);
    frame.stamp = {frame_, frame_ * 100'000, host_now_ns()};
    shared_.made = ++frame_;
    return SourceEvent{0, std::move(frame)};
  }

 private:
  Shared& shared_;
  SessionHeader header_;
  std::int64_t frames_, frame_ = -1;
  std::atomic<bool> stopped_{false};
};

// Faults of a link; each lasts for a while.
enum class Outage { none, silence, reset, half_bandwidth, odd_splits };

class SpoiledStream : public ByteStream {
 public:
  SpoiledStream(std::unique_ptr<ByteStream> inner, const std::atomic<Outage>& outage)
      : inner_(std::move(inner)), outage_(outage) {}
  std::size_t read_some(std::span<std::byte> into, milliseconds at_most) override {
    if (outage_ == Outage::reset) throw LinkLost("reset");
    if (outage_ == Outage::silence) {
      std::this_thread::sleep_for(at_most);
      return 0;
    }
    return inner_->read_some(
        outage_ == Outage::odd_splits ? into.first(std::min<std::size_t>(into.size(), 3)) : into, at_most);
  }
  void write_all(std::span<const std::byte> from) override {
    if (outage_ == Outage::reset) throw LinkLost("reset");
    while (outage_ == Outage::silence) std::this_thread::sleep_for(milliseconds(5));
    if (outage_ == Outage::half_bandwidth)  // of what this sensor makes
      std::this_thread::sleep_for(std::chrono::microseconds(from.size() * 20));
    for (std::size_t part = outage_ == Outage::odd_splits ? 7 : from.size(); !from.empty();) {
      inner_->write_all(from.first(std::min(part, from.size())));
      from = from.subspan(std::min(part, from.size()));
    }
  }

 private:
  std::unique_ptr<ByteStream> inner_;
  const std::atomic<Outage>& outage_;
};

std::uint16_t free_port() { return StreamListener(SocketAddress{"127.0.0.1", 0}).port(); }

[[noreturn]] void record_and_exit(const std::filesystem::path& session, std::uint16_t port) {
  CaptureOptions options;
  options.agents = 1;
  options.look_period_s = 0.05;
  options.reserve_bytes = 0;
  options.listen = [&] {
    for (int i = 0;; ++i) try {  // the killed one's socket may linger
        return std::make_unique<StreamListener>(SocketAddress{"127.0.0.1", port});
      } catch (const InputError&) {
        if (i > 100) throw;
        std::this_thread::sleep_for(milliseconds(50));
      }
  };
  try {
    std::_Exit(capture({}, session, options).log_left.empty() ? 0 : 3);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "recorder: %s\n", error.what());
    std::_Exit(2);
  }
}

// Of this program alone: what else is tried on this machine at the same time may find a port that was given
// up.
std::string agent_name() {
  static const std::string name = fmt::format("t{}", getpid());
  return name;
}

AgentOptions agent_options(const std::filesystem::path& folder, std::uint16_t port) {
  AgentOptions options;
  options.name = agent_name();
  options.folder = folder;
  options.reserve_bytes = 0;
  options.link.min_retry_delay = milliseconds(10);
  options.link.last_retry = milliseconds(100);
  options.connect = [port] { return connect_loopback({"127.0.0.1", port}); };
  return options;
}

int run_source(Shared& shared, std::int64_t frames, const AgentOptions& options) {
  std::vector<std::unique_ptr<FrameSource>> source;
  source.push_back(std::make_unique<EternalSource>(shared, frames));
  try {
    return run_agent(source, options).left.empty() ? 0 : 3;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "agent: %s\n", error.what());
    return 2;
  }
}

template <class Work>
pid_t in_a_process(const Work& work) {
  const pid_t child = fork();
  if (child == 0) work();
  return child;
}

void kill_now(pid_t child) {
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

bool ended_well(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// Empty when each frame that was made is in the session once or counted as lost. `gaps`: restarts of the
// agent, each of which may miscount two frames by their times.
std::string difference(const std::filesystem::path& path, std::int64_t first, std::int64_t made, int gaps) {
  const SessionReader session(path);
  const std::uint64_t stored = session.counts(0).body_frames;
  std::set<std::int64_t> numbers;
  for (const BodyFrame& frame : session.body_frames(0, 0, stored)) {
    const BodyFrame expected = PatternSource::bodies_of(0, frame.stamp.sequence);
    if (frame.bodies.size() != expected.bodies.size() ||
        (!frame.bodies.empty() && frame.bodies[0].position_m != expected.bodies[0].position_m))
      return fmt::format("frame {} is another", frame.stamp.sequence);
    if (!numbers.insert(frame.stamp.sequence).second)
      return fmt::format("frame {} is there twice", frame.stamp.sequence);
  }
  const auto drops = session.drop_counts(0);
  const std::int64_t lost = drops.empty() ? 0 : drops.back().at_source + drops.back().in_queue;
  const std::int64_t all = made - first, found = static_cast<std::int64_t>(stored) + lost;
  if (std::abs(found - all) > 2 * gaps + (gaps > 0 ? 1 : 0))
    return fmt::format("{} frames are stored and {} lost, {} were made", stored, lost, all);
  if (gaps == 0 && lost > 0) return fmt::format("{} frames are lost", lost);
  return {};
}

struct TrialFolder {
  std::filesystem::path path;
  explicit TrialFolder(std::filesystem::path folder) : path(std::move(folder)) {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
  }
};

Shared& shared_numbers() {
  (void)agent_name();  // before there are other processes
  void* memory = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  static Shared* shared = new (memory) Shared;
  shared->start_ns = shared->made = 0;
  shared->first = -1;
  return *shared;
}

// Nothing is said of a trial that ends well.
void report(int trial, const std::string& what, const std::string& problem) {
  std::fprintf(stderr, "trial %d (%s): %s\n", trial, what.c_str(), problem.c_str());
}

std::string kill_trial(const RandomStream& random, const std::filesystem::path& folder, bool kill_recorder,
                       bool kill_agent) {
  constexpr std::int64_t kFrames = 250;
  Shared& shared = shared_numbers();
  const std::uint16_t port = free_port();
  const std::filesystem::path session = folder / "s.h5";
  const auto record = [&] { return in_a_process([&] { record_and_exit(session, port); }); };
  const auto send = [&] {
    return in_a_process([&] { std::_Exit(run_source(shared, kFrames, agent_options(folder, port))); });
  };
  pid_t recorder = record(), agent = send();
  while (shared.made == 0) std::this_thread::sleep_for(milliseconds(2));
  // what never reached the recorder is counted by the time only
  while (std::ranges::none_of(logs_beside(session), [&](const auto& log) {
    return log.filename().string().starts_with("s.h5." + agent_name()) &&
           std::filesystem::file_size(log) > 1000;
  }))
    std::this_thread::sleep_for(milliseconds(2));
  std::this_thread::sleep_for(std::chrono::duration<double>(0.1 + 1.5 * random.uniform(0)));
  if (kill_recorder) kill_now(recorder);
  if (kill_agent) kill_now(agent);
  std::this_thread::sleep_for(std::chrono::duration<double>(0.05 + 0.3 * random.uniform(1)));
  if (kill_recorder) recorder = record();
  if (kill_agent) agent = send();
  const bool agent_is_well = ended_well(agent), recorder_is_well = ended_well(recorder);
  if (!agent_is_well || !recorder_is_well) return "a process did not end well";
  return difference(session, shared.first, shared.made, kill_agent ? 1 : 0);
}

std::string outage_trial(const RandomStream& random, double longest_s, const std::filesystem::path& folder) {
  const double outage_s = 0.1 * std::pow(longest_s / 0.1, random.uniform(0));
  const auto kind = static_cast<Outage>(1 + static_cast<int>(4.0 * random.uniform(1)));
  const auto frames = static_cast<std::int64_t>(kRate_hz * (1.0 + outage_s));
  Shared& shared = shared_numbers();
  const std::uint16_t port = free_port();
  const pid_t recorder = in_a_process([&] { record_and_exit(folder / "s.h5", port); });
  std::atomic<Outage> outage{Outage::none};
  AgentOptions options = agent_options(folder, port);
  options.connect = [&]() -> std::unique_ptr<ByteStream> {
    if (outage == Outage::reset || outage == Outage::silence) throw LinkLost("an outage");
    return std::make_unique<SpoiledStream>(connect_loopback({"127.0.0.1", port}), outage);
  };
  std::thread spoiler([&] {
    while (shared.made == 0) std::this_thread::sleep_for(milliseconds(2));
    std::this_thread::sleep_for(milliseconds(300));
    outage = kind;
    std::this_thread::sleep_for(std::chrono::duration<double>(outage_s));
    outage = Outage::none;
  });
  const int code = run_source(shared, frames, options);
  spoiler.join();
  if (!ended_well(recorder) || code != 0)
    return fmt::format("outage {} of {:.1f} s: a side did not end well", static_cast<int>(kind), outage_s);
  const std::string problem = difference(folder / "s.h5", shared.first, shared.made, 0);
  return problem.empty()
             ? problem
             : fmt::format("outage {} of {:.1f} s: {}", static_cast<int>(kind), outage_s, problem);
}

}  // namespace

int torture_with_kills(int trials, std::uint64_t seed, const std::filesystem::path& folder) {
  int failed = 0;
  for (int i = 0; i < trials; ++i) {
    const RandomStream random{seed, Purpose::sensor_drop, static_cast<std::uint64_t>(i)};
    const TrialFolder trial(folder / "link");
    const std::string problem = kill_trial(random, trial.path, i % 3 != 1, i % 3 != 0);
    if (problem.empty()) continue;
    ++failed;
    report(i, i % 3 == 0 ? "recorder killed" : i % 3 == 1 ? "agent killed" : "both killed", problem);
  }
  fmt::print(
      "{} kills of recorder, agent or both: {} recordings with frames lost uncounted, twice or wrong\n",
      trials, failed);
  return failed;
}

int torture_with_outages(int trials, double longest_s, std::uint64_t seed,
                         const std::filesystem::path& folder) {
  int failed = 0;
  for (int i = 0; i < trials; ++i) {
    const RandomStream random{seed, Purpose::arrival_delay, static_cast<std::uint64_t>(i)};
    const TrialFolder trial(folder / "link");
    const std::string problem = outage_trial(random, longest_s, trial.path);
    if (problem.empty()) continue;
    ++failed;
    report(i, "outage", problem);
  }
  fmt::print("{} outages of up to {:.1f} s: {} recordings with frames lost, twice or wrong\n", trials,
             longest_s, failed);
  return failed;
}

int torture_logs(int trials, std::uint64_t seed, const std::filesystem::path& folder) {
  const TrialFolder trial(folder / "logs");
  const std::filesystem::path path = trial.path / "a.trilog";
  std::vector<BodyFrame> written;
  {
    SessionHeader header;
    header.sensors.resize(1);
    header.sensors[0].name = "k1";
    EventLogWriter log(path, new_log_head(header));
    for (std::int64_t i = 0; i < 40; ++i) {
      written.push_back(PatternSource::bodies_of(0, i));
      log.append(0, written.back());
    }
    log.finish();
  }
  const std::string sound = read_file(path);
  int wrong = 0;
  for (int i = 0; i < trials; ++i) {
    const RandomStream random{seed, Purpose::test, static_cast<std::uint64_t>(i)};
    std::string bytes = sound;
    const auto place = [&](std::uint32_t draw) {
      return static_cast<std::size_t>(random.uniform(draw) * static_cast<double>(bytes.size()));
    };
    if (i % 2 == 0) bytes.resize(place(0));
    for (std::uint32_t flip = 0; flip < static_cast<std::uint32_t>(i % 4) && !bytes.empty(); ++flip)
      bytes[place(1 + 2 * flip)] ^=
          static_cast<char>(1 << static_cast<int>(8.0 * random.uniform(2 + 2 * flip)));
    bool is_wrong = false;
    LogScanner scanner("a log", [&](std::size_t, LogEvent&& event) {
      const auto* frame = std::get_if<BodyFrame>(&event);
      const auto number = frame ? static_cast<std::size_t>(frame->stamp.sequence) : written.size();
      is_wrong =
          is_wrong || number >= written.size() || frame->bodies.size() != written[number].bodies.size() ||
          (!frame->bodies.empty() && frame->bodies[0].position_m != written[number].bodies[0].position_m);
    });
    try {
      scanner.feed(std::as_bytes(std::span(bytes)));
      (void)scanner.finish();
    } catch (const InputError&) {  // the head is gone
    }
    wrong += is_wrong ? 1 : 0;
  }
  fmt::print("{} cut or flipped logs: {} gave a record that had not been written\n", trials, wrong);
  return wrong;
}

}  // namespace trilat
