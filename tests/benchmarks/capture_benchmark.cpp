// SPDX-License-Identifier: MIT
// How much of the machine a recording takes, how far it is from its first lost frame, and how much smaller
// the file is than the raw depth; beside a recorder that one would write first, which hands raw frames to the
// HDF5 library, compressed on the one thread that writes.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <sys/resource.h>

#include "datasets/hdf5/hdf5_file.h"
#include "datasets/session/session_layout.h"
#include "recorders/capture.h"
#include "recorders/open_source.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kSensors = 4;
constexpr double kRate_hz = 30.0;

double processor_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// What one virtual Kinect delivers, rendered before the clock starts.
struct Rendered {
  std::vector<BodyFrame> bodies;
  std::vector<DepthFrame> depth;
};

// Four, with the declared noise.
std::vector<Rendered> render(double seconds) {
  const auto source = open_source(fmt::format("synthetic:{},duration={},speed=max", kSensors, seconds));
  std::vector<Rendered> rendered(kSensors);
  while (auto event = source->next()) {
    if (auto* frame = std::get_if<BodyFrame>(&event->data))
      rendered[event->sensor].bodies.push_back(std::move(*frame));
    if (auto* depth = std::get_if<DepthFrame>(&event->data))
      rendered[event->sensor].depth.push_back(std::move(*depth));
  }
  return rendered;
}

// The same frames again and again at a fixed rate, stamped with this machine's clock and taken or not: a load
// whose making costs no more than a copy.
class LoopedSource : public FrameSource {
 public:
  LoopedSource(const std::vector<Rendered>& sensors, double rate_hz, double seconds)
      : sensors_(sensors), rate_hz_(rate_hz), frames_(static_cast<std::int64_t>(seconds * rate_hz)) {
    header_.simulated = true;
    for (std::size_t s = 0; s < kSensors; ++s) {
      SensorDescription& sensor = header_.sensors.emplace_back();
      sensor.name = fmt::format("k{}", s + 1);
      sensor.source = "simulated";
      sensor.has_depth = true;
    }
  }
  const SessionHeader& header() const override { return header_; }
  void stop() override { stopped_ = true; }
  bool live() const override { return true; }

  // Of each frame the sensors one after the other, a sensor's bodies before its depth.
  std::optional<SourceEvent> next() override {
    const std::int64_t frame = events_ / static_cast<std::int64_t>(2 * kSensors);
    if (stopped_ || frame >= frames_) return std::nullopt;
    const std::size_t part = static_cast<std::size_t>(events_++) % (2 * kSensors), sensor = part / 2;
    const auto since_start = std::chrono::duration<double>(static_cast<double>(frame) / rate_hz_);
    if (part == 0)
      std::this_thread::sleep_until(start_ + std::chrono::duration_cast<Clock::duration>(since_start));
    const Rendered& frames = sensors_[sensor];
    const std::size_t which =
        static_cast<std::size_t>(frame) % std::min(frames.bodies.size(), frames.depth.size());
    const FrameStamp stamp{frame, static_cast<std::int64_t>(1e7 * since_start.count()), host_now_ns()};
    if (part % 2 == 1) return SourceEvent{sensor, DepthFrame{stamp, frames.depth[which].depth_mm}};
    return SourceEvent{sensor,
                       BodyFrame{stamp, frames.bodies[which].floor_plane, frames.bodies[which].bodies}};
  }

 private:
  const std::vector<Rendered>& sensors_;
  SessionHeader header_;
  double rate_hz_;
  std::int64_t frames_, events_ = 0;
  Clock::time_point start_ = Clock::now();
  std::atomic<bool> stopped_{false};
};

struct Measured {
  double wall_s = 0.0, cores = 0.0, share_of_raw = 0.0;
  double end_s_per_gb = 0.0;  // from the last frame to the session that was read back
  std::int64_t lost = 0;
  double peak_waiting_mb = 0.0;
};

Measured record_at(const std::vector<Rendered>& rendered, double speed, double seconds,
                   const std::filesystem::path& path) {
  Measured m;
  CaptureOptions options;
  options.on_status = [&](const CaptureStatus& s) {
    m.peak_waiting_mb = std::max(m.peak_waiting_mb, 1e-6 * static_cast<double>(s.waiting_bytes));
  };
  std::optional<Clock::time_point> writing;
  double cores_s = 0.0;
  options.on_writing = [&](double) {
    if (!writing) {
      writing = Clock::now();
      cores_s = processor_s();
    }
    return true;
  };
  std::vector<std::unique_ptr<FrameSource>> sources;
  sources.push_back(std::make_unique<LoopedSource>(rendered, kRate_hz * speed, seconds));
  const double before_s = processor_s();
  const auto start = Clock::now();
  const CaptureSummary summary = capture(sources, path, options);
  const auto seconds_of = [](Clock::duration d) { return std::chrono::duration<double>(d).count(); };
  m.wall_s = seconds_of(writing.value_or(Clock::now()) - start);
  m.cores = (cores_s - before_s) / m.wall_s;
  m.end_s_per_gb = 1e9 * seconds_of(Clock::now() - writing.value_or(Clock::now())) /
                   static_cast<double>(summary.session_bytes);
  std::uint64_t frames = 0;
  for (const SensorStatus& s : summary.last.sensors) {
    frames += s.depth_frames;
    m.lost += s.lost_in_queue;
  }
  m.share_of_raw =
      static_cast<double>(summary.session_bytes) / static_cast<double>(frames * kDepthPixels * 2);
  std::filesystem::remove(path);
  return m;
}

// Seconds of processor time a frame when one thread compresses and writes, one frame after another: by Blosc,
// or by the library's own deflate inside its write.
double plain_recorder_s(const std::vector<Rendered>& rendered, const std::filesystem::path& path,
                        ChunkCompression compression) {
  const double before_s = processor_s();
  std::size_t frames = 0;
  {
    H5File file = H5File::create(path);
    const H5Layout layout{.chunk_rows = 1, .checksum = true, .compression = compression};
    for (std::size_t s = 0; s < kSensors; ++s) {
      H5Table table =
          file.create_table("depth" + std::to_string(s), H5Type::u16, {kDepthHeight, kDepthWidth}, layout);
      for (const DepthFrame& frame : rendered[s].depth) {
        const std::span<const std::uint16_t> pixels(frame.depth_mm);
        if (compression == ChunkCompression::blosc)
          table.append_filtered_row(encode_chunk(std::as_bytes(pixels), 2, compression));
        else
          table.append(pixels);
        ++frames;
      }
    }
    file.close();
  }
  const double seconds = (processor_s() - before_s) / static_cast<double>(frames);
  std::filesystem::remove(path);
  return seconds;
}

void run(double seconds, double step_seconds, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  fmt::print("rendering 2 s of four virtual Kinects with the declared noise (simulated)\n");
  const std::vector<Rendered> rendered = render(2.0);
  const Measured real = record_at(rendered, 1.0, seconds, folder / "session.h5");
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print(
      "real time, {:.0f} s: {} frames lost, {:.2f} cores (the source's copies included), file {:.1f} % of "
      "raw depth, at "
      "most {:.0f} MB waiting; its end takes {:.1f} s a GB, read back; {:.0f} MB of memory, of which {:.0f} "
      "are the "
      "source's frames\n",
      real.wall_s, real.lost, real.cores, 100.0 * real.share_of_raw, real.peak_waiting_mb, real.end_s_per_gb,
      1e-3 * static_cast<double>(usage.ru_maxrss),
      1e-6 * static_cast<double>(2 * kDepthPixels * kSensors * rendered[0].depth.size()));
  for (const double speed : {2.0, 4.0, 6.0, 8.0, 12.0, 16.0}) {
    const Measured m = record_at(rendered, speed, step_seconds, folder / "session.h5");
    fmt::print("{:>4.0f} x {:.0f} MB/s, {:.0f} s: {} frames lost, {:.2f} cores, at most {:.0f} MB waiting\n",
               speed, 1e-6 * speed * kSensors * kRate_hz * kDepthPixels * 2, m.wall_s, m.lost, m.cores,
               m.peak_waiting_mb);
    if (m.lost > 0) break;
  }
  const double ours_s = real.cores / (kSensors * kRate_hz);
  for (const auto& [name, compression] :
       {std::pair{"blosc", ChunkCompression::blosc}, std::pair{"deflate", ChunkCompression::deflate}}) {
    const double plain_s = plain_recorder_s(rendered, folder / "plain.h5", compression);
    fmt::print(
        "a frame: ours {:.2f} ms of processor time with bodies, stamps and flushes; {} on the thread that "
        "writes {:.2f} ms, which is {:.2f} times ours and full at {:.1f} x real time\n",
        1e3 * ours_s, name, 1e3 * plain_s, plain_s / ours_s, 1.0 / (plain_s * kSensors * kRate_hz));
  }
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  CLI::App app("What recording four Kinects costs");
  double seconds = 20.0, step_seconds = 20.0;
  std::string folder = (std::filesystem::temp_directory_path() / "trilat_capture_benchmark").string();
  app.add_option("--seconds", seconds, "of the recording at real time; the paper's length is 600")
      ->capture_default_str();
  app.add_option("--step-seconds", step_seconds, "of each faster one")->capture_default_str();
  app.add_option("--folder", folder, "on the disk to be measured")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  trilat::run(seconds, step_seconds, folder);
  return 0;
}
