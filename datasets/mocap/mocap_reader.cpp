// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>

#include "datasets/base/error.h"
#include "datasets/mocap/column_rows.h"
#include "datasets/mocap/csv_cell.h"
#include "datasets/mocap/line_reader.h"
#include "datasets/mocap/motive_header.h"
#include "datasets/mocap/trackable_header.h"
#include "datasets/mocap/trackable_rows.h"
#include "datasets/mocap/trc_header.h"

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
                     "belong into a session: `python3 -m trilat.convert` makes one");
  if (line.starts_with("NO_OF_") || line.starts_with("FILE_VERSION"))
    throw InputError(place, "Qualisys' TSV is not read; export C3D from Qualisys Track Manager instead");
  if (line.starts_with('{') || line.starts_with('['))
    throw InputError(place,
                     "is JSON, and no motion capture; bodies of a Kinect belong into a session: `python3 -m "
                     "trilat.convert azure-kinect` makes one of offline_processor's JSON");
  if (line.starts_with("Format Version;"))
    throw InputError(place, "the cells are separated by semicolons; save the file with commas");
  if (line.starts_with("\xFF\xFE") || line.starts_with("\xFE\xFF"))
    throw InputError(place, "the text is UTF-16; save the file as UTF-8");
  throw InputError(place,
                   "this is not a motion capture file that can be read; known are Motive's CSV, which begins "
                   "with \"Format Version,1.2…\", the rows of Arena and Tracking Tools (\"comment,\") and "
                   "TRC (\"PathFileType\")");
}

// By its first two bytes: the block of the parameters, and a key.
bool is_c3d(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  constexpr int kKey = 0x50;
  std::ifstream file(path, std::ios::binary);
  const int block = file.get(), key = file.get();
  return key == kKey && block > 0 && block < ' ';
}

}  // namespace

bool begins_as_mocap(const std::filesystem::path& path) {
  if (is_c3d(path)) return true;
  LineReader lines(path, MocapReadOptions{}.block_bytes);
  std::string_view line;
  if (!lines.next(line)) return false;
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  return line.starts_with(kMotiveStart) || is_trc(line) || is_known_row(line);
}

MocapReader::MocapReader(const std::filesystem::path& path, MocapReadOptions options) {
  if (is_c3d(path))
    throw InputError(path.string(), "is C3D; python3 -m trilat.convert c3d " + path.string() + " -o " +
                                        std::filesystem::path(path).replace_extension(".csv").string());
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

FrozenPoses::FrozenPoses(const MocapHeader& header, FrozenOptions options)
    : options_(options), finest_step_m_(std::numeric_limits<double>::infinity()) {
  for (const MocapAsset& asset : header.assets)
    stretches_.emplace_back().is_solved = asset.type != AssetType::marker && asset.type != AssetType::other;
}

std::int64_t FrozenPoses::add(std::size_t asset, const MocapPose& pose, bool present, MocapTime time) {
  Stretch& stretch = stretches_[asset];
  if (!present) {
    stretch.frames = 0;
    return 0;
  }
  const bool repeats = stretch.frames > 0 && same_bits(pose, stretch.pose);
  if (!repeats) {
    if (stretch.seen && pose.has_position() && stretch.pose.has_position())
      for (const double step_m : (pose.position_m - stretch.pose.position_m).cwiseAbs().eval())
        if (step_m > 0.0) finest_step_m_ = std::min(finest_step_m_, step_m);
    stretch.moved |= stretch.seen && !same_bits(pose, stretch.pose);
    stretch.seen = true;
    stretch.pose = pose;
    stretch.start = time;
    stretch.frames = 1;
    stretch.frozen = false;
    return 0;
  }
  ++stretch.frames;
  if (stretch.frozen) return 1;
  stretch.frozen = stretch.is_solved && stretch.moved && finest_step_m_ <= options_.finest_step_m &&
                   stretch.frames >= options_.min_frames &&
                   time - stretch.start >= duration_from_s(options_.min_s);
  return stretch.frozen ? stretch.frames : 0;
}

MocapPositions read_positions(MocapReader& reader, const std::vector<std::size_t>& assets, MocapTime until) {
  reader.read_only(assets);
  MocapPositions result;
  result.header = reader.header();
  result.position_m.resize(result.header.assets.size());
  if (until.ns == std::numeric_limits<std::int64_t>::max()) {
    constexpr std::int64_t kMost = 10'000'000;  // whatever the header says
    const auto frames = static_cast<std::size_t>(
        std::clamp<std::int64_t>(result.header.total_exported_frames.value_or(0), 0, kMost));
    for (const std::size_t asset : assets) result.position_m[asset].reserve(frames);
  }
  FrozenPoses poses(result.header);
  MocapFrame frame;
  while ((result.time.empty() || result.time.back() < until) && reader.next(frame)) {
    if (result.time.empty() && std::isfinite(frame.printed_time_s)) result.first_s = frame.printed_time_s;
    result.time.push_back(frame.time);
    for (const std::size_t asset : assets) {
      const MocapPose& pose = frame.poses[asset];
      std::vector<Eigen::Vector3d>& position_m = result.position_m[asset];
      const bool at_origin = pose.position_m.isZero(0.0);
      position_m.push_back(at_origin ? MocapPose().position_m : pose.position_m);
      result.removed.at_origin += at_origin ? 1 : 0;
      const bool present = !at_origin && pose.is_present(result.header.assets[asset]);
      const std::int64_t frozen = poses.add(asset, pose, present, frame.time);
      std::fill(position_m.end() - frozen, position_m.end(), MocapPose().position_m);
      result.removed.frozen += frozen;
    }
  }
  result.anomalies = reader.anomalies();
  return result;
}

}  // namespace trilat
