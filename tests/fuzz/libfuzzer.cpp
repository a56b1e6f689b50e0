// SPDX-License-Identifier: MIT
// All fuzzers as one program of libFuzzer; TRILAT_FUZZER names the one to run.
#include <cstdlib>

#include "tests/fuzz/fuzzers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const char* name = std::getenv("TRILAT_FUZZER");
  trilat::fuzz(name ? name : "", {data, size});
  return 0;
}
