// SPDX-License-Identifier: MIT
// A Kinect20.dll without a Kinect, to try trilat-agent.exe under wine: 30 exposures a second of a wall 1.5 m
// away with one body, and a table of rays half a pixel beside the intrinsics.
#include <chrono>
#include <deque>
#include <mutex>
#include <thread>

#include <windows.h>

#include "tests/recorders/fake_kinect.h"

namespace trilat::kinect::fake {
namespace {

Desk the_desk;

// A count of exposures to take is the semaphore's, so that none is missed.
struct PacedReader : Reader {
  PacedReader() : Reader(the_desk) {}
  HResult SubscribeMultiSourceFrameArrived(WaitableHandle* handle) override {
    arrived_ = ::CreateSemaphoreW(nullptr, 0, 1000, nullptr);
    std::thread([this] { expose(); }).detach();
    return *handle = reinterpret_cast<WaitableHandle>(arrived_), kOk;
  }
  HResult GetMultiSourceFrameArrivedEventData(WaitableHandle,
                                              IMultiSourceFrameArrivedEventArgs** event) override {
    const std::lock_guard lock(mutex_);
    *event = new Arrival(exposures_.front(), desk);
    exposures_.pop_front();
    return kOk;
  }

 private:
  [[noreturn]] void expose() {
    using Ticks = std::chrono::duration<std::int64_t, std::ratio<1, 10'000'000>>;
    constexpr std::int64_t kPeriod = 333'333;
    const auto start = std::chrono::steady_clock::now();
    for (std::int64_t ticks = kPeriod;; ticks += kPeriod) {
      std::this_thread::sleep_until(start + Ticks(ticks));
      const std::lock_guard lock(mutex_);
      exposures_.push_back({ticks, ticks, 1500, true, false});
      ::ReleaseSemaphore(arrived_, 1, nullptr);
    }
  }

  HANDLE arrived_ = nullptr;
  std::mutex mutex_;
  std::deque<Exposure> exposures_;
};

struct PacedSensor : Sensor {
  PacedSensor() : Sensor(the_desk) {}
  HResult OpenMultiSourceFrameReader(std::uint32_t, IMultiSourceFrameReader** reader) override {
    return *reader = new PacedReader, kOk;
  }
};

}  // namespace
}  // namespace trilat::kinect::fake

extern "C" __declspec(dllexport) trilat::kinect::HResult
    __stdcall GetDefaultKinectSensor(trilat::kinect::IKinectSensor** sensor) {
  trilat::kinect::fake::the_desk.rays_right_px = 0.5;
  trilat::kinect::fake::the_desk.rays_down_px = 0.5;
  return *sensor = new trilat::kinect::fake::PacedSensor, trilat::kinect::kOk;
}
