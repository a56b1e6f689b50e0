// SPDX-License-Identifier: MIT
#include "datasets/import/node_kinect2_reader.h"
#include "tests/fuzz/read_body_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  trilat::read_body_file({data, size}, [](const std::filesystem::path& path) {
    return std::make_unique<trilat::NodeKinect2Reader>(path, trilat::node_kinect2_start_ms(path));
  });
  return 0;
}
