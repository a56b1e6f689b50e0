// SPDX-License-Identifier: MIT
// The three files one behind the other, with a zero byte between them.
#include <algorithm>

#include "datasets/import/kimore_reader.h"
#include "tests/fuzz/read_body_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  const auto first = std::find(bytes.begin(), bytes.end(), 0);
  const auto second = first == bytes.end() ? first : std::find(first + 1, bytes.end(), 0);
  const auto end_of = [&](auto at) { return at == bytes.end() ? at : at + 1; };
  const trilat::MemoryFile time(std::span(end_of(first), second));
  const trilat::MemoryFile orientation(std::span(end_of(second), bytes.end()));
  trilat::read_body_file(std::span(bytes.begin(), first), [&](const std::filesystem::path& path) {
    return std::make_unique<trilat::KimoreReader>(trilat::KimoreFiles{path, time.path(), orientation.path()},
                                                  30.0);
  });
  return 0;
}
