// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/base/error.h"
#include "datasets/import/import_body_files.h"
#include "tests/fuzz/memory_file.h"

namespace trilat {

// Reads the bytes as a file of bodies from end to end; only InputError may come of it.
template <class Open>
void read_body_file(std::span<const std::uint8_t> bytes, const Open& open) {
  const MemoryFile file(bytes);
  try {
    const auto reader = open(file.path());
    survey_body_file(*reader, "fuzz");
  } catch (const InputError&) {
  }
}

}  // namespace trilat
