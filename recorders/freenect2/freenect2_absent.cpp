// SPDX-License-Identifier: MIT
#include "datasets/base/error.h"
#include "recorders/freenect2/freenect2_source.h"

namespace trilat {

bool has_freenect2() { return false; }

std::unique_ptr<FrameSource> open_freenect2(const Freenect2Options&, const std::string& place) {
  throw InputError(
      place,
      "freenect2 is not in this build: install libfreenect2 (github.com/OpenKinect/libfreenect2), see that "
      "pkg-config finds freenect2, and configure anew");
}

}  // namespace trilat
