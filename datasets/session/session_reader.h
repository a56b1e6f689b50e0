// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/hdf5/chunk_codec.h"
#include "datasets/session/session_types.h"

namespace trilat {

struct SensorCounts {
  std::uint64_t body_frames = 0;
  std::uint64_t bodies = 0;
  std::uint64_t depth_frames = 0;
  std::uint64_t clock_exchanges = 0;
  std::uint64_t drop_counts = 0;
  std::uint64_t notices = 0;
  std::uint64_t notices_left_out = 0;  // beyond kMaxSessionNotices
  std::optional<ChunkCompression> depth_compression =
      std::nullopt;  // none where chunks are not as we write them
  // Rows that stand in some columns of a table but not in all: what a killed writer was in the middle of.
  std::uint64_t torn_rows = 0;
  // Frames of an unfinished session, from the first on whose number of bodies cannot be read.
  std::uint64_t unreadable_body_frames = 0;
};

// A depth frame as it lies in the file. decode_depth_frame() makes it an image, on any thread.
struct StoredDepthFrame {
  std::string place;  // `file.h5:/path`, for errors
  std::optional<ChunkCompression> compression;
  std::vector<std::byte> chunk;  // compressed; without `compression` the raw millimetres
};
// InputError when the frame is damaged. `depth_mm` holds kDepthPixels values.
void decode_depth_frame(const StoredDepthFrame& frame, std::span<std::uint16_t> depth_mm);

enum class FrameStream { bodies, depth };

// Reads session.h5 in blocks, so that memory does not depend on the recording's length. Opens a file that is
// being written, or whose writer was killed: then up to the last flush. Counts are what all columns of a
// table hold in common; nothing is read on the word of a stored length. InputError with `file.h5:/path` for
// whatever is not as this format version has it. Any number of threads may read from one.
class SessionReader {
 public:
  explicit SessionReader(const std::filesystem::path& path);
  ~SessionReader();
  SessionReader(SessionReader&&) noexcept;

  const std::filesystem::path& path() const;
  const SessionHeader& header() const;
  const std::string& created_by() const;
  // False when the recording was not closed properly (or still goes on).
  bool complete() const;
  const SensorCounts& counts(std::size_t sensor) const;
  // Bytes of the sensor's depth frames in the file; 0 without depth. Looks at every chunk's entry.
  std::uint64_t depth_stored_bytes(std::size_t sensor) const;
  std::size_t sensor_index(const std::string& name) const;  // InputError listing those that exist

  // Each reads rows [first, first + count) and refuses a range beyond counts().
  std::vector<FrameStamp> stamps(std::size_t sensor, FrameStream stream, std::uint64_t first,
                                 std::uint64_t count) const;
  std::vector<BodyFrame> body_frames(std::size_t sensor, std::uint64_t first, std::uint64_t count) const;
  void depth_frame(std::size_t sensor, std::uint64_t index, std::span<std::uint16_t> depth_mm) const;
  // Only reads; what costs is left to decode_depth_frame().
  StoredDepthFrame stored_depth_frame(std::size_t sensor, std::uint64_t index) const;
  std::vector<ClockExchange> clock_exchanges(std::size_t sensor) const;
  std::vector<ClockExchange> clock_exchanges(std::size_t sensor, std::uint64_t first,
                                             std::uint64_t count) const;
  std::vector<DropCount> drop_counts(std::size_t sensor) const;
  std::vector<SensorNotice> notices(std::size_t sensor) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace trilat
