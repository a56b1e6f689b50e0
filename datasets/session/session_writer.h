// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "datasets/hdf5/chunk_codec.h"
#include "datasets/session/session_types.h"

namespace trilat {

// InputError with `place` for a header that no session may have: no sensor, too many, two of one name.
void check_session_header(const SessionHeader& header, const std::string& place);

// Writes session.h5 (format 1). The file is `path`.partial until finish() renames it, and is removed where
// that is not called: what must outlive a kill is written as an event log first. One thread at a time. Errors
// of the disk are OutputError; after one, nothing more is written.
class SessionWriter {
 public:
  SessionWriter(const std::filesystem::path& path, const SessionHeader& header,
                ChunkCompression depth_compression = ChunkCompression::blosc);
  ~SessionWriter();
  SessionWriter(const SessionWriter&) = delete;
  SessionWriter& operator=(const SessionWriter&) = delete;

  void add_body_frame(std::size_t sensor, const BodyFrame& frame);
  // Recompresses a frame that is not compressed as the session is; InputError where such a frame is damaged.
  void add_depth_frame(std::size_t sensor, const EncodedDepthFrame& frame);
  void add_clock_exchange(std::size_t sensor, const ClockExchange& exchange);
  void add_drop_count(std::size_t sensor, const DropCount& count);
  // Texts are cut at 240 bytes.
  void add_notice(std::size_t sensor, const SensorNotice& notice);
  // Marks the file complete and gives it its final name.
  void finish();

 private:
  template <class Work>
  void guarded(const Work& work);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace trilat
