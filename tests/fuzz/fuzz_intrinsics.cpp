// SPDX-License-Identifier: MIT
#include "datasets/base/error.h"
#include "datasets/calibration/opencv_intrinsics.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const trilat::MemoryFile file({data, size});
  try {
    (void)trilat::read_opencv_intrinsics(file.path(), 512, 424);
  } catch (const trilat::InputError&) {
  }
  return 0;
}
