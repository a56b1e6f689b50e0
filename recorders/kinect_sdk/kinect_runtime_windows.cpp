// SPDX-License-Identifier: MIT
#include <objbase.h>
#include <windows.h>

#include "datasets/base/error.h"
#include "recorders/kinect_sdk/kinect_source.h"

namespace trilat::kinect {

KinectRuntime load_kinect_runtime() {
  const HMODULE library = ::LoadLibraryExW(L"Kinect20.dll", nullptr, LOAD_LIBRARY_SEARCH_SYSTEM32);
  if (!library)
    throw InputError("the source kinect",
                     "needs the Kinect for Windows Runtime 2.0, which is not installed (no Kinect20.dll)");
  using GetSensor = HResult(__stdcall*)(IKinectSensor**);
  const auto get_sensor = reinterpret_cast<GetSensor>(
      reinterpret_cast<void*>(::GetProcAddress(library, "GetDefaultKinectSensor")));
  if (!get_sensor) throw InputError("Kinect20.dll", "is not the runtime of a Kinect v2");
  const auto wait = [](WaitableHandle handle, std::chrono::milliseconds at_most) {
    return ::WaitForSingleObject(reinterpret_cast<HANDLE>(handle), static_cast<DWORD>(at_most.count())) ==
           WAIT_OBJECT_0;
  };
  return {get_sensor, wait, ::CoTaskMemFree};
}

}  // namespace trilat::kinect
