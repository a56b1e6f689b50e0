// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "datasets/hdf5/chunk_codec.h"
#include "recorders/frame_source.h"

namespace trilat {

struct RecordOptions {
  ChunkCompression depth_compression = ChunkCompression::blosc;
  std::function<bool()> stop_requested = {};  // asked now and then
};

struct RecordSummary {
  std::uint64_t body_frames = 0;
  std::uint64_t depth_frames = 0;
};

// Stores everything the source delivers in `path` (session.h5) until it ends. Throws Interrupted when asked
// to stop, and nothing is left then.
RecordSummary record(FrameSource& source, const std::filesystem::path& path, const RecordOptions& options);

}  // namespace trilat
