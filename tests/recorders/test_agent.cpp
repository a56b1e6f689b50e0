// SPDX-License-Identifier: MIT
// test_agent NAME HOST:PORT FOLDER lose SHARE | silent SECONDS: an agent whose sensor delivers bodies at 30
// Hz and loses some of them, or falls silent after so long while its agent lives.
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "datasets/base/philox.h"
#include "recorders/agent/run_agent.h"

namespace trilat {
namespace {

std::atomic<bool> stop_wanted{false};

class FaultySource : public FrameSource {
 public:
  FaultySource(double lost_share, double silent_after_s)
      : lost_share_(lost_share), silent_after_s_(silent_after_s) {
    SensorDescription sensor;
    sensor.name = "kinect";
    sensor.source = "test";
    header_.sensors = {sensor};
    header_.simulated = true;
  }
  const SessionHeader& header() const override { return header_; }
  bool live() const override { return true; }
  void stop() override { stopped_ = true; }
  std::optional<SourceEvent> next() override {
    if (start_ns_ == 0) start_ns_ = host_now_ns();
    while (lost_share_ > 0.0 && random_.uniform(static_cast<std::uint32_t>(frame_)) < lost_share_) ++frame_;
    while (!stopped_ &&
           (host_now_ns() < due_ns() || 1e-9 * static_cast<double>(due_ns() - start_ns_) > silent_after_s_))
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    if (stopped_) return std::nullopt;
    BodyFrame frame{{frame_, frame_ * 333'333, host_now_ns()}, {}, {Body{.tracking_id = 1}}};
    for (auto& point : frame.bodies[0].position_m)
      point = {0.1f, 0.2f, 2.0f + 1e-4f * static_cast<float>(frame_)};
    ++frame_;
    return SourceEvent{0, std::move(frame)};
  }

 private:
  std::int64_t due_ns() const { return start_ns_ + frame_ * 33'333'300; }

  SessionHeader header_;
  RandomStream random_{1, Purpose::sensor_drop, 0};
  double lost_share_, silent_after_s_;
  std::int64_t frame_ = 0, start_ns_ = 0;
  std::atomic<bool> stopped_{false};
};

int run(const std::string& name, const std::string& address, const std::string& folder,
        const std::string& fault, double value) {
  AgentOptions options;
  options.name = name;
  options.folder = folder;
  options.connect = [at = parse_address(address)] { return connect_loopback(at); };
  options.stop_requested = [] { return stop_wanted.load(); };
  std::vector<std::unique_ptr<FrameSource>> source;
  source.push_back(
      std::make_unique<FaultySource>(fault == "lose" ? value : 0.0, fault == "silent" ? value : 1e9));
  const AgentReport report = run_agent(source, options);
  std::printf("%s: %lld lost at the source\n", name.c_str(), static_cast<long long>(report.lost_at_source));
  return report.whole() ? 0 : 1;
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  if (argc != 6) return 2;
  std::signal(SIGTERM, [](int) { trilat::stop_wanted = true; });
  return trilat::run(argv[1], argv[2], argv[3], argv[4], std::atof(argv[5]));
}
