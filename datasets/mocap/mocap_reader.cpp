// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_reader.h"

#include <cstring>
#include <string>
#include <utility>

#include "datasets/base/error.h"
#include "datasets/mocap/c3d_rows.h"
#include "datasets/mocap/column_rows.h"
#include "datasets/mocap/csv_cell.h"
#include "datasets/mocap/line_reader.h"
#include "datasets/mocap/motive_header.h"
#include "datasets/mocap/trackable_header.h"
#include "datasets/mocap/trackable_rows.h"

namespace trilat {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::string_view kMotiveStart = "Format Version";

bool is_numbers_only(std::string_view line) {
  const auto cells = split_csv(line);
  std::int64_t frame = 0;
  double time_s = 0.0;
  return cells.size() >= 2 && parse_integer(cells[0], frame) &&
         parse_cell(cells[1], time_s) == CellKind::number;
}

[[noreturn]] void refuse_file(std::string_view line, const std::string& place) {
  if (is_numbers_only(line))
    throw InputError(place,
                     "the file begins with data and has no header, so that unit, rate and names are unknown; "
                     "when it is Motive's, export it again with the header switched on. Bodies of a Kinect "
                     "are a session's: `trilat import` reads them");
  if (line.starts_with("NO_OF_") || line.starts_with("FILE_VERSION"))
    throw InputError(place,
                     "Qualisys' TSV is not read any more; export C3D from Qualisys Track Manager instead");
  if (line.starts_with("Format Version;"))
    throw InputError(place, "the cells are separated by semicolons; save the file with commas");
  if (line.starts_with("\xFF\xFE") || line.starts_with("\xFE\xFF"))
    throw InputError(place, "the text is UTF-16; save the file as UTF-8");
  throw InputError(
      place,
      "this is no motion capture that can be read; known are Motive's CSV, which begins with \"Format "
      "Version,1.2…\", the rows of Arena and Tracking Tools (\"comment,\"), TRC (\"PathFileType\") and C3D");
}

}  // namespace

MocapReader::MocapReader(const std::filesystem::path& path, MocapReadOptions options) {
  if (is_c3d(path)) {
    rows_ = std::make_unique<C3dRows>(path, header_);
    return;
  }
  lines_ = std::make_unique<LineReader>(path, options.block_bytes);
  std::string_view line;
  if (!lines_->next(line)) throw InputError(lines_->place(), "the file is empty");
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  const auto read_columns = [&](ColumnHeader columns) {
    header_ = std::move(columns.header);
    rows_ = std::make_unique<ColumnRows>(*lines_, header_, std::move(columns.layout));
  };
  if (split_csv(line).front() == kMotiveStart) {
    read_columns(read_motive_header(*lines_, line));
  } else if (is_trc(line)) {
    read_columns(read_trc_header(*lines_, line));
  } else if (is_known_row(line)) {
    TrackableHeader trackable = read_trackable_header(*lines_, line);
    header_ = trackable.header;
    rows_ = std::make_unique<TrackableRows>(*lines_, std::move(trackable));
  } else {
    refuse_file(line, lines_->place());
  }
}

MocapReader::~MocapReader() = default;

void MocapReader::read_only(const std::vector<std::size_t>& assets) {
  for (const std::size_t asset : assets) TRILAT_CHECK(asset < header_.assets.size(), "the asset exists");
  rows_->read_only(assets);
}

bool MocapReader::next(MocapFrame& frame) { return rows_->next(frame, anomalies_); }

namespace {

bool same_bits(const MocapPose& a, const MocapPose& b) {
  return std::memcmp(a.position_m.data(), b.position_m.data(), 3 * sizeof(double)) == 0 &&
         std::memcmp(a.rotation.coeffs().data(), b.rotation.coeffs().data(), 4 * sizeof(double)) == 0;
}

}  // namespace

FrozenFilter::FrozenFilter(MocapReader& reader, FrozenOptions options)
    : reader_(reader),
      options_(options),
      stretches_(reader.header().assets.size()),
      removed_(stretches_.size(), 0) {}

// A stretch through the oldest frame has by now either ended or become long enough.
bool FrozenFilter::is_decided() const {
  return ended_ || (static_cast<std::int64_t>(held_.size()) >= options_.min_frames &&
                    held_.back().time - held_.front().time >= duration_from_s(options_.min_s));
}

bool FrozenFilter::read_one() {
  if (!reader_.next(frame_)) return false;
  held_.push_back(frame_);
  for (std::size_t i = 0; i < stretches_.size(); ++i) {
    const bool sentinel = frame_.poses[i].position_m.isZero(0.0);
    if (sentinel) {
      held_.back().poses[i] = MocapPose();
      ++removed_[i];
    }
    const bool present = !sentinel && frame_.poses[i].is_present(reader_.header().assets[i]);
    const std::int64_t count = stretches_[i].add(frame_.poses[i], present, frame_.time, options_);
    removed_[i] += count;
    for (std::int64_t back = 1; back <= count; ++back)
      held_[held_.size() - static_cast<std::size_t>(back)].poses[i] = MocapPose();
  }
  return true;
}

bool FrozenFilter::next(MocapFrame& frame) {
  while (held_.empty() || !is_decided()) {
    if (ended_) return false;
    ended_ = !read_one();
  }
  std::swap(frame, held_.front());
  held_.pop_front();
  return true;
}

std::int64_t FrozenStretch::add(const MocapPose& pose, bool present, MocapTime time,
                                const FrozenOptions& options) {
  if (!present) {
    frames_ = 0;
    return 0;
  }
  if (frames_ == 0 || !same_bits(pose, pose_)) {
    pose_ = pose;
    start_ = time;
    frames_ = 1;
    frozen_ = false;
    return 0;
  }
  ++frames_;
  if (frozen_) return 1;
  frozen_ = frames_ >= options.min_frames && time - start_ >= duration_from_s(options.min_s);
  return frozen_ ? frames_ : 0;
}

}  // namespace trilat
