// SPDX-License-Identifier: MIT
// The HDF5 files of results and of the simulator: the first byte chooses the reader.
#include <algorithm>
#include <array>

#include "datasets/results/replay.h"
#include "datasets/results/samples.h"
#include "tests/fuzz/fuzz_folder.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/tolerate_bad_input.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 256;

void read_samples(const std::filesystem::path& path) {
  const SamplesFile samples = SamplesFile::open(path);
  for (std::size_t t = 0; t < samples.header().takes.size(); ++t) {
    const std::uint64_t count = std::min(kBlock, samples.header().takes[t].instants);
    samples.read(t, 0, count);
    samples.read_errors(t, 0, count);
  }
}

void read_replay_file(const std::filesystem::path& path) {
  static const FuzzFolder folder("replay");
  std::filesystem::remove(folder.path() / "replay.h5");
  std::filesystem::create_symlink(path, folder.path() / "replay.h5");
  read_replay(folder.path());
}

}  // namespace
}  // namespace trilat

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trilat;
  if (size == 0) return 0;
  const MemoryFile file({data + 1, size - 1});
  constexpr std::array kReaders{read_samples, read_replay_file};
  tolerate_bad_input([&] { kReaders[data[0] % kReaders.size()](file.path()); });
  return 0;
}
