// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>

#include "datasets/hdf5/chunk_codec.h"
#include "datasets/session/session_types.h"

namespace trilat {

// Writes session.h5 (format 1), append-only. The file is `path`.partial until finish() renames it;
// all that was flushed is readable if the process dies (see docs/how-to/record.md: a killed file is opened as
// an SWMR reader, never with h5clear). One thread at a time. Errors of the disk are OutputError and leave
// what was flushed; after one, nothing more is written.
class SessionWriter {
 public:
  SessionWriter(const std::filesystem::path& path, const SessionHeader& header,
                ChunkCompression depth_compression = ChunkCompression::blosc);
  ~SessionWriter();
  SessionWriter(const SessionWriter&) = delete;
  SessionWriter& operator=(const SessionWriter&) = delete;

  void add_body_frame(std::size_t sensor, const BodyFrame& frame);
  void add_depth_frame(std::size_t sensor, const EncodedDepthFrame& frame);
  void add_clock_exchange(std::size_t sensor, const ClockExchange& exchange);
  void add_drop_count(std::size_t sensor, const DropCount& count);
  // Texts are cut at 240 bytes.
  void add_notice(std::size_t sensor, const SensorNotice& notice);
  // Everything added so far survives a kill from here on. Call once a second.
  void flush();
  // Marks the file complete and gives it its final name.
  void finish();

 private:
  template <class Work>
  void guarded(const Work& work);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace trilat
