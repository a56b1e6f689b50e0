// SPDX-License-Identifier: MIT
#include <vector>

#include "datasets/base/error.h"
#include "datasets/import/import_png.h"
#include "datasets/import/import_types.h"
#include "datasets/session/session_types.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const trilat::MemoryFile file({data, size});
  std::vector<std::uint16_t> values(trilat::kDepthPixels);
  try {
    trilat::read_depth_png(file.path(), values);
  } catch (const trilat::InputError&) {
  } catch (const trilat::TornRow&) {
  }
  return 0;
}
