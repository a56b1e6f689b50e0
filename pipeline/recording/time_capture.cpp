// SPDX-License-Identifier: MIT
#include "pipeline/recording/time_capture.h"

#include <exception>
#include <memory>
#include <thread>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/recording/processing_time.h"
#include "recorders/capture.h"
#include "recorders/looped_source.h"
#include "recorders/network/agent_connect.h"
#include "recorders/network/agent_link.h"
#include "recorders/network/link/tls_keys.h"
#include "recorders/network/network_source.h"
#include "recorders/open_source.h"
#include "recorders/steady_time.h"

namespace trilat {
namespace {

constexpr double kRendered_s = 1.0;  // of frames that are repeated

// A virtual sensor's machine.
class Machine {
 public:
  Machine(std::shared_ptr<const SensorFrames> frames, const std::filesystem::path& key, std::uint16_t port,
          const RecordingSpec& spec)
      : source_({std::move(frames)}, spec.rate_hz, spec.capture_s),
        link_(source_, options_of(key),
              connect_to_server({"127.0.0.1", port}, std::make_shared<TlsIdentity>(key.string()), false)),
        thread_([this] { run(); }) {}
  ~Machine() {
    link_.stop();
    thread_.join();
  }

 private:
  static AgentOptions options_of(const std::filesystem::path& key) {
    AgentOptions options;
    options.name = key.stem().string();
    options.incarnation = 1;
    return options;
  }
  void run() {
    try {
      link_.run();
    } catch (const std::exception&) {
      // the recorder then waits in vain for this machine, or says what it lost
    }
  }
  LoopedSource source_;
  AgentLink link_;
  std::thread thread_;
};

struct CaptureTimes {
  std::vector<double> stored_s;
  std::int64_t lost = 0;
};

CaptureTimes record_over_tls(const RecordingSpec& spec, const std::filesystem::path& folder,
                             const Watch& watch) {
  std::vector<std::string> names;
  for (std::uint64_t s = 0; s < spec.sensors; ++s) names.push_back(fmt::format("k{}", s + 1));
  make_tls_keys(folder, names);
  const auto rendered = take_all(*open_source(fmt::format("synthetic:{},seed={},drop=0,duration={},speed=max",
                                                          spec.sensors, spec.seed, kRendered_s)));
  ListenOptions listen;
  listen.address = {"127.0.0.1", 0};
  listen.identity = std::make_shared<TlsIdentity>((folder / "server.pem").string());
  auto source = std::make_unique<NetworkSource>(listen);
  std::vector<std::unique_ptr<Machine>> machines;
  for (std::uint64_t s = 0; s < spec.sensors; ++s)
    machines.push_back(std::make_unique<Machine>(std::make_shared<const SensorFrames>(rendered[s]),
                                                 folder / (names[s] + ".pem"), source->port(), spec));
  source->wait_for_agents(spec.sensors, std::chrono::seconds(60), [&] { return watch.stopped(); });
  CaptureTimes times;
  CaptureOptions options;
  options.stop_requested = watch.stop_requested;
  options.on_depth_stored = [&](const FrameStamp& stamp) {
    times.stored_s.push_back(1e-9 * static_cast<double>(steady_now_ns() - stamp.arrival_ns));
  };
  if (watch.progress)
    options.on_status = [&](const CaptureStatus& s) {
      watch.progress(std::min(1.0, s.elapsed_s / spec.capture_s));
    };
  std::vector<std::unique_ptr<FrameSource>> sources;
  sources.push_back(std::move(source));
  const CaptureSummary summary = capture(sources, folder / "session.h5", options);
  if (summary.end == CaptureEnd::stop_requested) throw Interrupted();
  if (summary.end != CaptureEnd::source_ended)
    throw OutputError(
        (folder / "session.h5").string(),
        summary.problem.empty() ? "was not recorded to its end: the disk is nearly full" : summary.problem);
  for (const SensorStatus& s : summary.last.sensors) times.lost += s.lost_at_source + s.lost_in_queue;
  return times;
}

}  // namespace

std::vector<StageTiming> time_capture(const RecordingSpec& spec, const std::filesystem::path& folder,
                                      const Watch& watch) {
  if (spec.capture_s <= 0.0) return {};
  make_folder(folder);
  CaptureTimes times;
  try {
    times = record_over_tls(spec, folder, watch);
  } catch (...) {
    std::filesystem::remove_all(folder);
    throw;
  }
  std::filesystem::remove_all(folder);
  std::string how = "compressed, over TLS on loopback";
  if (times.lost > 0) how += fmt::format("; {} frames more were lost", times.lost);
  return {{"capture to stored", how, spread_times(std::move(times.stored_s))}};
}

}  // namespace trilat
