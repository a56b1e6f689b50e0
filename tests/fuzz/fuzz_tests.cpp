// SPDX-License-Identifier: MIT
// fuzz_tests NAME FOLDER: what the fuzzer NAME does to its input, done to the seeds in the folder: as they
// are, cut off at places, with single bytes changed and, where they are JSON, with values changed. The same
// inputs every time.
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

extern "C" {
// As libFuzzer calls it: the new size.
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed);
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);
}

// The mutator of JSON leaves what is none to this; single bytes are changed anyway.
std::size_t LLVMFuzzerMutate(std::uint8_t*, std::size_t size, std::size_t) { return size; }

namespace trilat {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kCuts = 20, kChangesOfBytes = 50, kChangesOfJson = 50;
constexpr std::size_t kInputs = 200;  // of a fuzzer, about: many seeds have fewer changes each

struct Shares {
  std::size_t cuts, bytes, json;
};

Shares shares_of(std::size_t seeds) {
  const std::size_t all = kCuts + kChangesOfBytes + kChangesOfJson;
  const std::size_t each = std::min(all, std::max<std::size_t>(8, kInputs / seeds));
  return {kCuts * each / all, kChangesOfBytes * each / all, kChangesOfJson * each / all};
}

Bytes bytes_of(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  return {text.begin(), text.end()};
}

// Results have a byte before their JSON.
bool is_json(const Bytes& seed) {
  return std::any_of(seed.begin(), seed.begin() + std::min<std::ptrdiff_t>(2, std::ssize(seed)),
                     [](std::uint8_t byte) { return byte == '{' || byte == '['; });
}

// An input lies in memory of just its size, so that a sanitizer sees every read beyond it.
void give(const std::string& fuzzer, const Bytes& input) {
  Bytes exact(input.begin(), input.end());
  exact.shrink_to_fit();
  fuzz(fuzzer, exact);
}

void try_seed(const std::string& fuzzer, const Bytes& seed, std::uint64_t number, const Shares& shares) {
  give(fuzzer, seed);
  for (std::size_t cut = 0; cut < shares.cuts; ++cut)
    give(fuzzer, {seed.begin(),
                  seed.begin() + static_cast<std::ptrdiff_t>((cut + 1) * seed.size() / (shares.cuts + 1))});
  const RandomStream random{1, Purpose::test, number};
  std::uint32_t draw = 0;
  const auto below = [&](std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(random.uniform(draw++) * static_cast<double>(count)));
  };
  for (std::size_t k = 0; k < shares.bytes && !seed.empty(); ++k) {
    Bytes changed = seed;
    const std::size_t place = below(seed.size());
    changed[place] = static_cast<std::uint8_t>(changed[place] + 1 + below(255));
    give(fuzzer, changed);
  }
  for (unsigned k = 0; k < shares.json && is_json(seed); ++k) {
    Bytes changed = seed;
    const std::size_t most = 2 * seed.size() + 1000;
    changed.resize(most);
    changed.resize(LLVMFuzzerCustomMutator(changed.data(), seed.size(), most, k));
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
    try_seed(name, bytes_of(file), number++, shares_of(files.size()));
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
