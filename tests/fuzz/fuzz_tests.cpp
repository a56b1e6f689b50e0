// SPDX-License-Identifier: MIT
// fuzz_tests NAME FOLDER: what the fuzzer NAME does to its input, done to the seeds in the folder: as they
// are, cut off at places, and with single bytes changed. The same inputs every time.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/files.h"
#include "datasets/base/philox.h"
#include "tests/fuzz/fuzzers.h"

namespace trilat {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kCuts = 20, kChangesOfBytes = 50;

Bytes bytes_of(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  return {text.begin(), text.end()};
}

// An input lies in memory of just its size, so that a sanitizer sees every read beyond it.
void give(const std::string& fuzzer, const Bytes& input) {
  Bytes exact(input.begin(), input.end());
  exact.shrink_to_fit();
  fuzz(fuzzer, exact);
}

void try_seed(const std::string& fuzzer, const Bytes& seed, std::uint64_t number) {
  give(fuzzer, seed);
  for (std::size_t cut = 0; cut < kCuts; ++cut)
    give(fuzzer,
         {seed.begin(), seed.begin() + static_cast<std::ptrdiff_t>((cut + 1) * seed.size() / (kCuts + 1))});
  const RandomStream random{1, Purpose::test, number};
  std::uint32_t draw = 0;
  const auto below = [&](std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(random.uniform(draw++) * static_cast<double>(count)));
  };
  for (std::size_t k = 0; k < kChangesOfBytes && !seed.empty(); ++k) {
    Bytes changed = seed;
    const std::size_t place = below(seed.size());
    changed[place] = static_cast<std::uint8_t>(changed[place] + 1 + below(255));
    give(fuzzer, changed);
  }
}

std::vector<std::filesystem::path> files_in_order(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  if (std::filesystem::exists(folder))
    for (const auto& file : std::filesystem::directory_iterator(folder)) files.push_back(file.path());
  std::ranges::sort(files);
  return files;
}

int run(const std::string& name, const std::filesystem::path& folder) {
  const auto files = files_in_order(folder);
  std::uint64_t number = 0;
  give(name, {});
  for (const std::filesystem::path& file : files) {
    std::printf("%s\n", file.filename().c_str());
    std::fflush(stdout);
    try_seed(name, bytes_of(file), number++);
  }
  if (!files.empty()) return 0;
  std::fprintf(stderr, "fuzz_tests: %s: holds no seeds of \"%s\"\n", folder.c_str(), name.c_str());
  return 1;
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: fuzz_tests NAME FOLDER\n");
    return 2;
  }
  try {
    return trilat::run(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuzz_tests: the reader let this out: %s\n", error.what());
    return 1;
  }
}
