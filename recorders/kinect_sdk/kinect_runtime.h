// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <functional>

#include "recorders/kinect_sdk/sdk_interfaces.h"

namespace trilat::kinect {

// Calls of the Kinect runtime and of Windows that a source needs.
struct KinectRuntime {
  std::function<HResult(IKinectSensor** sensor)> default_sensor;
  // True when the handle was signalled within the time.
  std::function<bool(WaitableHandle handle, std::chrono::milliseconds at_most)> wait;
  std::function<void(void* memory)> free;  // what the runtime gave away
};

// Loads Kinect20.dll. InputError where it is not installed. Windows only.
KinectRuntime load_kinect_runtime();

}  // namespace trilat::kinect
