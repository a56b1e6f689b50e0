// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <deque>

#include "recorders/frame_source.h"
#include "recorders/kinect_sdk/com_pointer.h"
#include "recorders/kinect_sdk/kinect_bodies.h"
#include "recorders/kinect_sdk/kinect_runtime.h"
#include "recorders/kinect_sdk/tick_sequence.h"

namespace trilat {

struct KinectOptions {
  std::chrono::milliseconds first_frame_limit{15000};  // the sensor takes some seconds to wake up
  std::chrono::milliseconds silence_limit{2000};       // without frames, then a notice says so
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
  bool available();
  void take_frame();
  void take_depth(kinect::IMultiSourceFrame& frame, std::int64_t arrival_ns);
  void take_bodies(kinect::IMultiSourceFrame& frame, std::int64_t arrival_ns);
  void mind_silence();
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
  std::int64_t last_frame_ns_ = 0;
  std::string said_;  // of the present silence
  std::atomic<bool> stopped_{false};
};

}  // namespace trilat
