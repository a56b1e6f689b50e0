// SPDX-License-Identifier: MIT
#include "datasets/import/joint_row_reader.h"
#include "tests/fuzz/read_body_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  trilat::read_body_file({data, size}, [](const std::filesystem::path& path) {
    return std::make_unique<trilat::JointRowReader>(path, trilat::kUmonsTaichiRows);
  });
  return 0;
}
