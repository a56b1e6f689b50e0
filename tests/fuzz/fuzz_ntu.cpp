// SPDX-License-Identifier: MIT
#include "datasets/import/ntu_reader.h"
#include "tests/fuzz/read_body_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  trilat::read_body_file({data, size}, [](const std::filesystem::path& path) {
    return std::make_unique<trilat::NtuReader>(path, 30.0);
  });
  return 0;
}
