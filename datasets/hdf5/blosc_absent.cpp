// SPDX-License-Identifier: MIT
#include "datasets/base/error.h"
#include "datasets/hdf5/blosc_codec.h"

namespace trilat {

bool has_blosc() { return false; }

std::vector<std::byte> blosc_bytes(std::span<const std::byte>, std::size_t) {
  TRILAT_CHECK(false, "Blosc is not called where it is not installed");
  return {};
}

bool unblosc_bytes(std::span<const std::byte>, std::span<std::byte>) { return false; }

}  // namespace trilat
