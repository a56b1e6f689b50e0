// SPDX-License-Identifier: MIT
#include "datasets/base/version.h"

#include "datasets/base/files.h"

namespace trilat {

std::string build_id() {
  static const std::string id = hash_of_file("/proc/self/exe");
  return id;
}

}  // namespace trilat
