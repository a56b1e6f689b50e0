// SPDX-License-Identifier: MIT
// A motion capture in any of its formats, read as it is inspected, as ground truth and as a motion.
#include "datasets/mocap/mocap_reader.h"
#include "datasets/mocap/mocap_summary.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/tolerate_bad_input.h"

namespace trilat {
namespace {

void read_some_assets(const std::filesystem::path& path) {
  MocapReader reader(path, {.block_bytes = 64});
  std::vector<std::size_t> assets;
  for (std::size_t a = 0; a < reader.header().assets.size(); a += 2) assets.push_back(a);
  reader.read_only(assets);
  MocapFrame frame;
  while (reader.next(frame)) {
  }
}

}  // namespace
}  // namespace trilat

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trilat;
  const MemoryFile file({data, size});
  tolerate_bad_input([&] {
    MocapReader reader(file.path(), {.block_bytes = 4096});
    summarize_mocap(reader);
  });
  tolerate_bad_input([&] { read_some_assets(file.path()); });
  return 0;
}
