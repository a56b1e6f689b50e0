// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "recorders/open_source.h"

namespace trilat {

// What only the simulator knows of a recording of `synthetic` sensors, so that it can be evaluated: a folder
// with the OptiTrack export, the mapping, the sensors' true poses, and a campaign whose one take is the
// recording. The export is written before the recording starts and covers `duration_s` of it, or a minute.
class RecordTruth {
 public:
  // InputError unless there is one source, a synthetic one at real speed.
  RecordTruth(const std::vector<std::string>& sources, const std::filesystem::path& folder,
              double duration_s);
  // Starts the source and writes the campaign.
  void finish(FrameSource& source, const std::filesystem::path& session) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace trilat
