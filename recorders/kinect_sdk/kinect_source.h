// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "datasets/session/session_types.h"
#include "recorders/frame_source.h"
#include "recorders/kinect_sdk/sdk_interfaces.h"

namespace trilat {
namespace kinect {

// Calls of the Kinect runtime and of Windows that a source needs.
struct KinectRuntime {
  std::function<HResult(IKinectSensor** sensor)> default_sensor;
  // True when the handle was signalled within the time.
  std::function<bool(WaitableHandle handle, std::chrono::milliseconds at_most)> wait;
  std::function<void(void* memory)> free;  // what the runtime gave away
};

// Loads Kinect20.dll. InputError where it is not installed. Windows only.
KinectRuntime load_kinect_runtime();

// The SDK's six body objects, which it makes once and fills anew for every frame. One thread at a time.
class KinectBodies {
 public:
  KinectBodies() = default;
  ~KinectBodies();
  KinectBodies(const KinectBodies&) = delete;
  KinectBodies& operator=(const KinectBodies&) = delete;

  // False where the frame gives no bodies.
  bool refresh(IBodyFrame& frame);
  // The tracked ones of the last refresh(), as the SDK gives them.
  std::vector<Body> tracked() const;

 private:
  std::array<IBody*, kBodyCount> slots_{};
};

}  // namespace kinect

// Numbers the frames of streams that share a device clock but carry no numbers. A gap of n periods skips
// n - 1 numbers, frames of one exposure get one number, and numbers of a stream always rise.
class TickSequence {
 public:
  TickSequence(std::size_t streams, std::int64_t period_ticks)
      : period_ticks_(period_ticks), last_(streams, -1) {}

  std::int64_t number_of(std::size_t stream, std::int64_t ticks) {
    const std::int64_t periods = last_ticks_ ? rounded_periods(ticks - *last_ticks_) : 0;
    // a step far back, or further ahead than an hour, is a sensor that began anew
    constexpr std::int64_t kMaxPeriodsBack = 30, kMaxPeriodsAhead = 108'000;
    const bool restarted = periods < -kMaxPeriodsBack || periods > kMaxPeriodsAhead;
    const std::int64_t number = std::max(restarted ? newest_ + 1 : newest_ + periods, last_[stream] + 1);
    last_[stream] = number;
    if (restarted || !last_ticks_ || periods > 0) last_ticks_ = ticks;
    newest_ = std::max(newest_, number);
    return number;
  }

 private:
  std::int64_t rounded_periods(std::int64_t ticks) const {
    const std::int64_t half = period_ticks_ / 2;
    return (ticks + (ticks < 0 ? -half : half)) / period_ticks_;
  }

  std::int64_t period_ticks_;
  std::optional<std::int64_t> last_ticks_;  // of the frame numbered newest_
  std::int64_t newest_ = 0;
  std::vector<std::int64_t> last_;
};

struct KinectOptions {
  std::chrono::milliseconds first_frame_limit{15000};  // the sensor takes some seconds to wake up
  std::chrono::milliseconds idle_timeout{2000};        // without frames, then a notice says so
};

// Depth and bodies of this computer's Kinect v2 through the Kinect for Windows SDK 2.0, never colour. Either
// may be missing of an exposure. Arrivals are stamped with this machine's steady clock. A sensor that is
// unplugged is waited for.
class KinectSource : public FrameSource {
 public:
  // Waits for the first frame, without which the SDK knows no intrinsics: InputError where none comes.
  explicit KinectSource(kinect::KinectRuntime runtime, KinectOptions options = {});
  ~KinectSource() override;
  KinectSource(const KinectSource&) = delete;
  KinectSource& operator=(const KinectSource&) = delete;

  const SessionHeader& header() const override { return header_; }
  std::optional<SourceEvent> next() override;
  void stop() override { stopped_ = true; }
  bool live() const override { return true; }

 private:
  void open();
  void describe();
  bool read_intrinsics(DepthIntrinsics& intrinsics);
  void move_principal_point(kinect::ICoordinateMapper& mapper, DepthIntrinsics& intrinsics);
  bool available();
  void lose(std::int64_t frames);
  bool has_frame() const;
  void take_frame();
  void take_depth(kinect::IMultiSourceFrame& frame, std::int64_t arrival_ns);
  void take_bodies(kinect::IMultiSourceFrame& frame, std::int64_t arrival_ns);
  void check_silence();
  void say(const std::string& text);

  kinect::KinectRuntime runtime_;
  KinectOptions options_;
  kinect::ComPointer<kinect::IKinectSensor> sensor_;
  kinect::ComPointer<kinect::IMultiSourceFrameReader> reader_;
  kinect::WaitableHandle arrived_ = 0;
  kinect::KinectBodies bodies_;
  SessionHeader header_;
  TickSequence sequence_;
  std::deque<SourceEvent> ready_;
  std::int64_t lost_ = 0;  // frames that could not be acquired, since the start
  std::int64_t last_frame_ns_ = 0;
  std::string said_;  // of the present silence
  std::atomic<bool> stopped_{false};
};

}  // namespace trilat
