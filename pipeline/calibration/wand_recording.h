// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "datasets/geometry/depth_camera.h"
#include "datasets/session/session_reader.h"
#include "pipeline/calibration/floor_plane.h"

namespace trilat {

struct RecordedSensor {
  std::string name;
  std::uint64_t frames = 0;  // with depth
  DepthIntrinsics intrinsics;
  std::optional<FloorPlane> floor = std::nullopt;
};

// What a calibration needs to know of a recording of the wand besides what its depth frames show.
struct WandRecording {
  std::string place;  // the file, for errors
  std::uint64_t bytes = 0;
  std::string fingerprint = {}, sha256 = {};  // empty as long as nobody asked
  bool simulated = false;
  std::vector<RecordedSensor> sensors = {};
};

using NamedIntrinsics = std::vector<std::pair<std::string, std::filesystem::path>>;  // sensor, OpenCV file

// Of recordings of one rig, without hashes. `intrinsics`: instead of the sessions' own; `floors`: whether
// they are looked for. InputError names the sensor that has no depth or other images, the recording with
// other sensors than the first, or the intrinsics file that cannot be this sensor's.
std::vector<WandRecording> read_wand_recordings(std::span<const SessionReader> sessions,
                                                const NamedIntrinsics& intrinsics, bool floors);

bool are_of_one_rig(const WandRecording& a, const WandRecording& b);
std::vector<DepthIntrinsics> intrinsics_of(const WandRecording& recording);

}  // namespace trilat
