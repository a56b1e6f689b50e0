// SPDX-License-Identifier: MIT
#include "datasets/calibration/opencv_intrinsics.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/tolerate_bad_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const trilat::MemoryFile file({data, size});
  trilat::tolerate_bad_input([&] { (void)trilat::read_opencv_intrinsics(file.path(), 512, 424); });
  return 0;
}
