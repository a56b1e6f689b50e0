// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "datasets/base/byte_file.h"
#include "datasets/import/xef_layout.h"

namespace trilat {

// A depth image or a body frame in a .xef.
struct XefEvent {
  xef::StreamKind kind = xef::StreamKind::other;
  std::uint64_t offset = 0;   // of the event in the file
  std::uint64_t data_at = 0;  // of its payload
  xef::EventHeader header{};
  std::optional<std::int64_t> frame_number{};
};

// The events of Kinect Studio's .xef, plain or archived, in the order of the file. Steps over damage to the
// next place that can only be an event; other streams are skipped and counted.
class XefReader {
 public:
  // InputError when it is another kind of file.
  explicit XefReader(const std::filesystem::path& path);

  // The next event of depth or bodies; false at the end.
  bool next(XefEvent& event);
  // The event's payload, inflated; TornRow when it is damaged or has another length than `bytes`.
  void read_payload(const XefEvent& event, std::span<std::byte> bytes) const;

  std::string place(const XefEvent& event) const { return file_.place(event.offset); }
  std::uint64_t bytes_read() const { return at_; }
  std::int64_t skipped_events() const { return skipped_events_; }
  std::int64_t skipped_bytes() const { return skipped_bytes_; }
  bool has_raw_infrared() const { return has_raw_infrared_; }

 private:
  struct Stream {
    xef::StreamKind kind = xef::StreamKind::other;
    std::uint16_t tag_bytes = 0;
    std::int64_t last_ticks = 0;
  };
  std::optional<xef::EventHeader> header_at(std::uint64_t offset) const;
  // Bytes of the event up to the next one; nothing when no event can be here.
  std::optional<std::uint64_t> event_bytes(std::uint64_t offset, const xef::EventHeader& header) const;
  std::optional<std::uint64_t> index_block_bytes(std::uint64_t offset) const;
  bool is_footer(std::uint64_t offset, const xef::EventHeader& header) const;
  bool can_begin(std::uint64_t offset) const;
  bool must_begin(std::uint64_t offset, std::span<const std::byte> bytes) const;
  // Takes a stream's description; false when there is none.
  bool take_description(const xef::EventHeader& header);
  void step_over_damage();

  ByteFile file_;
  std::int32_t stream_count_ = 0;
  std::map<std::uint16_t, Stream> streams_;
  std::uint64_t at_ = xef::kFileHeaderBytes;
  std::int64_t skipped_events_ = 0, skipped_bytes_ = 0;
  bool has_raw_infrared_ = false;
};

}  // namespace trilat
