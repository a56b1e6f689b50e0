// SPDX-License-Identifier: MIT
#include "datasets/import/xef_reader.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <zlib.h>

#include "datasets/base/error.h"
#include "datasets/import/import_types.h"

namespace trilat {
namespace {

using namespace xef;

constexpr std::uint64_t kScanBytes = 1u << 16;
constexpr std::uint64_t kNameBytes = kEventHeaderBytes + kDescriptionTagBytes + kNameEventBytes;
constexpr std::uint64_t kGuidBytes = kEventHeaderBytes + kDescriptionTagBytes + kGuidEventBytes;

bool has_possible_sizes(const EventHeader& header) {
  const bool compressed = header.flags == kCompressed;
  return header.flags <= kCompressed && header.stored_bytes <= kLargestEventBytes &&
         header.full_bytes <= kLargestEventBytes && (compressed || header.full_bytes == header.stored_bytes);
}

std::uint32_t payload_bytes(StreamKind kind) {
  return kind == StreamKind::depth ? kDepthBytes : kBodyFrameBytes;
}

bool is_wanted(StreamKind kind) { return kind == StreamKind::depth || kind == StreamKind::bodies; }

}  // namespace

XefReader::XefReader(const std::filesystem::path& path) : file_(path) {
  std::array<std::byte, kFileHeaderBytes> bytes{};
  const bool long_enough = file_.read(0, bytes);
  const auto begins = [&](std::string_view text) {
    return long_enough && std::memcmp(bytes.data(), text.data(), text.size()) == 0;
  };
  if (begins("PK"))
    throw InputError(
        file_.path(),
        "is a zip archive, as HoloLens writes under the same ending; Kinect Studio's .xef is expected");
  if (!begins(std::string_view(kMagic.data(), kMagic.size())))
    throw InputError(file_.path(), "does not begin with EVENTS1 as Kinect Studio's .xef does");
  stream_count_ = value_at<std::int32_t>(bytes, kStreamCountAt);
}

std::optional<EventHeader> XefReader::header_at(std::uint64_t offset) const {
  std::array<std::byte, kEventHeaderBytes> bytes{};
  if (!file_.read(offset, bytes)) return {};
  return event_header(bytes);
}

std::optional<std::uint64_t> XefReader::event_bytes(std::uint64_t offset, const EventHeader& header) const {
  const auto stream = streams_.find(header.stream);
  if (stream == streams_.end() || !has_possible_sizes(header)) return {};
  const std::uint64_t bytes = kEventHeaderBytes + stream->second.tag_bytes + header.stored_bytes;
  if (bytes > file_.size() - offset) return {};
  return bytes;
}

// Its length stands nowhere: the one behind which something begins.
std::optional<std::uint64_t> XefReader::index_block_bytes(std::uint64_t offset) const {
  for (const std::uint64_t payload : kIndexBlockBytes) {
    const std::uint64_t bytes = kEventHeaderBytes + payload;
    if (can_begin(offset + bytes)) return bytes;
  }
  return {};
}

bool XefReader::is_footer(std::uint64_t offset, const EventHeader& header) const {
  return stream_count_ > 0 && header.stream == stream_count_ && !streams_.contains(header.stream) &&
         file_.size() - offset <= kFooterBytes;
}

// Whether the file ends here, or an event, a description or a footer may begin.
bool XefReader::can_begin(std::uint64_t offset) const {
  if (offset == file_.size()) return true;
  const auto header = header_at(offset);
  if (!header) return false;
  if (header->stream == kIndexBlock) return header->flags == 0;
  return event_bytes(offset, *header) || is_footer(offset, *header) ||
         (header->stored_bytes == kNameEventBytes && header->flags <= kCompressed);
}

// The rule for taking up the thread behind damage: a frame of the right length, later than the last of its
// stream, with something behind it that may begin.
bool XefReader::must_begin(std::uint64_t offset, std::span<const std::byte> bytes) const {
  const EventHeader header = event_header(bytes);
  const auto stream = streams_.find(header.stream);
  if (stream == streams_.end() || !is_wanted(stream->second.kind)) return false;
  if (header.full_bytes != payload_bytes(stream->second.kind) || header.ticks < stream->second.last_ticks)
    return false;
  const auto length = event_bytes(offset, header);
  return length && can_begin(offset + *length);
}

void XefReader::step_over_damage() {
  std::vector<std::byte> window(kScanBytes + kEventHeaderBytes);
  const std::uint64_t begin = at_;
  for (++at_; at_ + kEventHeaderBytes <= file_.size();) {
    const std::uint64_t count = std::min<std::uint64_t>(window.size(), file_.size() - at_);
    if (!file_.read(at_, std::span(window).first(count))) break;
    for (std::uint64_t i = 0; i + kEventHeaderBytes <= count; ++i)
      if (must_begin(at_ + i, std::span(window).subspan(i, kEventHeaderBytes))) {
        at_ += i;
        skipped_bytes_ += static_cast<std::int64_t>(at_ - begin);
        return;
      }
    at_ += count - kEventHeaderBytes + 1;
  }
  at_ = file_.size();
  skipped_bytes_ += static_cast<std::int64_t>(at_ - begin);
}

// A name event and, behind it, the event with the stream's GUID; eight bytes more lie between them in some
// files.
bool XefReader::take_description(const EventHeader& header) {
  if (header.stored_bytes != kNameEventBytes || header.flags > kCompressed) return false;
  std::vector<std::byte> name(kDescriptionTagBytes + kNameEventBytes);
  if (!file_.read(at_ + kEventHeaderBytes, name)) return false;
  const auto number = value_at<std::uint16_t>(name, 0);
  if (streams_.contains(number) || number == kIndexBlock) return false;
  for (const std::uint64_t extra : {std::uint64_t{0}, kCompressedNameExtraBytes}) {
    const auto guid = header_at(at_ + kNameBytes + extra);
    if (!guid || guid->stored_bytes != kGuidEventBytes) continue;
    Stream stream;
    stream.kind = stream_kind(std::span(name).subspan(kDataTypeAt, 16));
    stream.tag_bytes = value_at<std::uint16_t>(name, kDescriptionTagBytes + kTagSizeAt);
    has_raw_infrared_ = has_raw_infrared_ || stream.kind == StreamKind::raw_infrared;
    streams_[number] = stream;
    at_ = std::min(file_.size(), at_ + kNameBytes + extra + kGuidBytes);
    return true;
  }
  return false;
}

bool XefReader::next(XefEvent& event) {
  while (at_ < file_.size()) {
    const auto header = header_at(at_);
    if (header && is_footer(at_, *header)) return false;
    if (header && header->stream == kIndexBlock && header->flags == 0) {
      const auto bytes = index_block_bytes(at_);
      bytes ? void(at_ += *bytes) : step_over_damage();
      continue;
    }
    if (header && take_description(*header)) continue;
    const auto length = header ? event_bytes(at_, *header) : std::nullopt;
    if (!length) {
      step_over_damage();
      continue;
    }
    Stream& stream = streams_[header->stream];
    event = {stream.kind, at_, at_ + kEventHeaderBytes + stream.tag_bytes, *header, {}};
    at_ += *length;
    if (!is_wanted(stream.kind)) {
      skipped_events_ += header->stream != 0;
      continue;
    }
    stream.last_ticks = std::max(stream.last_ticks, header->ticks);
    std::array<std::byte, 4> tag{};
    if (stream.tag_bytes == tag.size() && file_.read(event.offset + kEventHeaderBytes, tag))
      event.frame_number = value_at<std::uint32_t>(tag, 0);
    return true;
  }
  return false;
}

void XefReader::read_payload(const XefEvent& event, std::span<std::byte> bytes) const {
  if (event.header.full_bytes != bytes.size())
    throw TornRow{
        fmt::format("is a frame of {} bytes; {} are expected", event.header.full_bytes, bytes.size())};
  const bool compressed = event.header.flags == kCompressed;
  if (!compressed) {
    if (!file_.read(event.data_at, bytes)) throw TornRow{"is where the file ends, within a frame"};
    return;
  }
  std::vector<std::byte> stored(event.header.stored_bytes);
  if (!file_.read(event.data_at, stored)) throw TornRow{"is where the file ends, within a frame"};
  uLongf inflated = bytes.size();
  const int result = ::uncompress(reinterpret_cast<Bytef*>(bytes.data()), &inflated,
                                  reinterpret_cast<const Bytef*>(stored.data()), stored.size());
  if (result != Z_OK || inflated != bytes.size()) throw TornRow{"is a frame that cannot be decompressed"};
}

}  // namespace trilat
