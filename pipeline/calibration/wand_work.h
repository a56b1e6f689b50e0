// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "datasets/session/session_reader.h"
#include "pipeline/calibration/calibrate_views.h"
#include "pipeline/study/hash_cache.h"

namespace trilat {

// All positions, refined together; the paper's eq. 6 and 7, corrected; and as printed.
enum class WandMethod { wand, two_positions, printed };
std::string name_of(WandMethod method);

// 20 s of a Kinect: short enough to share one recording out, long enough that writing it down costs nothing.
inline constexpr std::uint64_t kFramesOfItem = 600;

// All that a calibration from a wand is made from, but for what the depth frames show.
struct WandWork {
  WandMethod method = WandMethod::wand;
  CalibrateWandOptions options;
  std::vector<WandRecording> recordings = {};
  std::uint64_t frames_of_item = kFramesOfItem;  // how it is divided among shards, in multiples of kWandBlock
  std::vector<CalibrationSource> other_sources = {};  // besides the recordings
};

// A reader of each file. Opening one reads the list of all its chunks, so each is opened once.
std::vector<SessionReader> open_sessions(const std::vector<std::filesystem::path>& files);

// All files that the calibration is made from, the recordings and others; to be asked before they are opened.
WatchedFiles watched_files(const std::vector<std::filesystem::path>& recordings,
                           const CalibrateWandOptions& options);

// InputError as read_wand_recordings(). The recordings' hashes are left out.
WandWork make_wand_work(std::span<const SessionReader> sessions, WandMethod method,
                        const CalibrateWandOptions& options);
// The recordings and the others.
std::vector<CalibrationSource> sources_of(const WandWork& work);

// What must be equal in parts of one work. It comes back without folders and sha256 of the recordings, and
// options that no command line sets come back with their defaults.
Json json_of(const WandWork& work);
WandWork read_wand_work(const Json& json, const std::string& place);
Json json_of(const DepthIntrinsics& intrinsics);

}  // namespace trilat
