// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/import/import_types.h"
#include "datasets/import/xef_reader.h"

namespace trilat {

// Frames of each kind in the file; both may be zero.
struct XefSurvey {
  std::int64_t depth_frames = 0;
  std::int64_t body_frames = 0;
};
XefSurvey survey_xef(XefReader& reader);

// One Kinect Studio recording to a session of one sensor.
ImportReport import_xef(const std::vector<std::filesystem::path>& files, const std::filesystem::path& output,
                        const ImportOptions& options);

}  // namespace trilat
