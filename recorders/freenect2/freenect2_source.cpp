// SPDX-License-Identifier: MIT
#include "recorders/freenect2/freenect2_source.h"

#include <atomic>
#include <utility>

#include <libfreenect2/frame_listener.hpp>
#include <libfreenect2/libfreenect2.hpp>
#include <libfreenect2/logger.h>
#include <libfreenect2/packet_pipeline.h>

#include "datasets/base/error.h"
#include "recorders/frame_source.h"
#include "recorders/freenect2/depth_feed.h"

namespace trilat {
namespace {

constexpr std::size_t kFramesAhead = 30;
constexpr std::chrono::milliseconds kLookPeriod{100};

// Frames are copied, so the library keeps its own.
class Listener : public libfreenect2::FrameListener {
 public:
  explicit Listener(DepthFeed& feed) : feed_(feed) {}
  bool onNewFrame(libfreenect2::Frame::Type type, libfreenect2::Frame* frame) override {
    const std::int64_t arrival_ns = steady_now_ns();
    if (type != libfreenect2::Frame::Depth) return false;
    const bool fits = frame->width * frame->height == kDepthPixels && frame->bytes_per_pixel == sizeof(float);
    const auto* pixels = reinterpret_cast<const float*>(frame->data);
    feed_.push({{pixels, fits ? kDepthPixels : 0}, frame->timestamp, frame->sequence, frame->status != 0},
               arrival_ns);
    return false;
  }

 private:
  DepthFeed& feed_;
};

// The library frees it.
libfreenect2::PacketPipeline* make_pipeline(const std::string& name, const std::string& place) {
  if (name == "cpu") return new libfreenect2::CpuPacketPipeline;
#ifdef LIBFREENECT2_WITH_OPENGL_SUPPORT
  if (name == "opengl") return new libfreenect2::OpenGLPacketPipeline;
#endif
#ifdef LIBFREENECT2_WITH_OPENCL_SUPPORT
  if (name == "opencl") return new libfreenect2::OpenCLPacketPipeline;
#endif
#ifdef LIBFREENECT2_WITH_CUDA_SUPPORT
  if (name == "cuda") return new libfreenect2::CudaPacketPipeline;
#endif
  throw InputError(place, "this libfreenect2 has no pipeline \"" + name + "\"; every one has cpu");
}

// The library's pixel centres lie at halves, ours at integers. Its tangential terms are those of OpenCV.
DepthIntrinsics intrinsics_of(const libfreenect2::Freenect2Device::IrCameraParams& from) {
  DepthIntrinsics in;
  in.fx_px = from.fx;
  in.fy_px = from.fy;
  in.cx_px = static_cast<double>(from.cx) - 0.5;
  in.cy_px = static_cast<double>(from.cy) - 0.5;
  in.k1 = from.k1;
  in.k2 = from.k2;
  in.k3 = from.k3;
  in.p1 = from.p1;
  in.p2 = from.p2;
  return in;
}

class Freenect2Source : public FrameSource {
 public:
  Freenect2Source(Freenect2Options options, std::string place)
      : options_(std::move(options)), place_(std::move(place)), feed_(kFramesAhead), listener_(feed_) {
    libfreenect2::setGlobalLogger(libfreenect2::createConsoleLogger(libfreenect2::Logger::Error));
    open();
    describe();
  }
  ~Freenect2Source() override {
    feed_.stop();
    close();
  }
  Freenect2Source(const Freenect2Source&) = delete;
  Freenect2Source& operator=(const Freenect2Source&) = delete;

  const SessionHeader& header() const override { return header_; }
  bool live() const override { return true; }
  void stop() override {
    stopped_ = true;
    feed_.stop();
  }
  std::optional<SourceEvent> next() override {
    for (std::int64_t silent_since_ns = steady_now_ns();;) {
      if (auto event = feed_.pop(kLookPeriod)) return event;
      if (stopped_) return std::nullopt;
      if (steady_now_ns() - silent_since_ns > std::chrono::nanoseconds(options_.silence_limit).count())
        throw InputError(place_,
                         "the Kinect " + header_.sensors[0].serial + " has fallen silent: unplugged?");
    }
  }

 private:
  void open() {
    const int count = library_.enumerateDevices();
    if (count == 0) throw InputError(place_, "there is no Kinect v2 on this computer's USB 3");
    if (count > 1 && options_.serial.empty())
      throw InputError(place_, "there are several Kinects; say which, as in freenect2:" +
                                   library_.getDeviceSerialNumber(0));
    const std::string serial = options_.serial.empty() ? library_.getDeviceSerialNumber(0) : options_.serial;
    device_ = library_.openDevice(serial, make_pipeline(options_.pipeline, place_));
    if (!device_)
      throw InputError(place_, "the Kinect " + serial + " cannot be opened: is it there, and may you?");
    libfreenect2::Freenect2Device::Config config;
    config.MinDepth = static_cast<float>(options_.min_depth_m);
    config.MaxDepth = static_cast<float>(options_.max_depth_m);
    config.EnableBilateralFilter = options_.bilateral_filter;
    config.EnableEdgeAwareFilter = options_.edge_aware_filter;
    device_->setConfiguration(config);
    device_->setIrAndDepthFrameListener(&listener_);
    if (device_->startStreams(false, true)) return;
    close();
    throw InputError(place_, "the Kinect " + serial + " does not start");
  }
  void close() {
    if (!device_) return;
    device_->stop();
    device_->close();
    device_ = nullptr;
  }
  void describe() {
    SensorDescription sensor;
    sensor.serial = device_->getSerialNumber();
    sensor.name = "kinect_" + sensor.serial;
    sensor.source = "libfreenect2";
    sensor.intrinsics = intrinsics_of(device_->getIrCameraParams());
    sensor.tick_ns = kFreenect2TickNs;
    sensor.latency_ns = kFreenect2LatencyNs;
    sensor.has_depth = true;
    header_.sensors.push_back(sensor);
    header_.note = "libfreenect2 " LIBFREENECT2_VERSION ", pipeline " + options_.pipeline + ", depth " +
                   std::to_string(options_.min_depth_m) + " to " + std::to_string(options_.max_depth_m) +
                   " m, bilateral filter " + (options_.bilateral_filter ? "on" : "off") +
                   ", edge-aware filter " + (options_.edge_aware_filter ? "on" : "off");
  }

  Freenect2Options options_;
  std::string place_;
  DepthFeed feed_;
  Listener listener_;
  libfreenect2::Freenect2 library_;
  libfreenect2::Freenect2Device* device_ = nullptr;  // the library's
  SessionHeader header_;
  std::atomic<bool> stopped_{false};
};

}  // namespace

bool has_freenect2() { return true; }

std::unique_ptr<FrameSource> open_freenect2(const Freenect2Options& options, const std::string& place) {
  return std::make_unique<Freenect2Source>(options, place);
}

}  // namespace trilat
