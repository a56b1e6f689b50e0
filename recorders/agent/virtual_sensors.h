// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "recorders/frame_source.h"

namespace trilat {

// "synthetic:N": N virtual Kinects (1 to 4) that watch a walking person for a minute, bodies only. InputError
// for any other text.
std::unique_ptr<FrameSource> open_virtual_sensors(const std::string& text);

}  // namespace trilat
