// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/text_output.h"
#include "datasets/mocap/column_rows.h"
#include "datasets/mocap/csv_cell.h"
#include "datasets/mocap/line_reader.h"
#include "datasets/mocap/motive_header.h"
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
                   "with \"Format Version,1.2…\", and TRC (\"PathFileType\")");
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

// Whether the first row of a file is one that Arena, Tracking Tools or Motive before version 1.2 wrote.
bool is_arena(std::string_view line) {
  constexpr std::string_view kRows[] = {"comment",   "info",      "righthanded", "lefthanded",
                                        "trackable", "rigidbody", "frame"};
  const std::string_view type = line.substr(0, line.find(','));
  return std::ranges::find(kRows, type.substr(0, type.find_last_not_of(" \t\r") + 1)) != std::end(kRows);
}

// The line that makes Motive's CSV of a file in another format.
[[noreturn]] void refuse_with_converter(const std::filesystem::path& path, const char* what,
                                        const char* format) {
  const bool is_c3d = format == std::string_view("c3d");
  const auto output = std::filesystem::path(path).replace_extension(is_c3d ? ".csv" : ".motive.csv");
  throw InputError(path.string(), fmt::format("is {}; python3 -m trilat.convert {} {} -o {}", what, format,
                                              shell_word(path.string()), shell_word(output.string())));
}

}  // namespace

bool begins_as_mocap(const std::filesystem::path& path) {
  if (is_c3d(path)) return true;
  LineReader lines(path, kBlockBytes);
  std::string_view line;
  if (!lines.next(line)) return false;
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  return line.starts_with(kMotiveStart) || is_trc(line) || is_arena(line);
}

MocapReader::MocapReader(const std::filesystem::path& path, std::size_t block_bytes) {
  if (is_c3d(path)) refuse_with_converter(path, "C3D", "c3d");
  lines_ = std::make_unique<LineReader>(path, block_bytes);
  std::string_view line;
  if (!lines_->next(line)) throw InputError(lines_->place(), "the file is empty");
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  const auto read_columns = [&](ColumnHeader columns) {
    header_ = std::move(columns.header);
    for (std::size_t i = 0; i < header_.assets.size(); ++i)
      header_.assets[i].column = std::ranges::min(columns.layout.columns[i]) + 1;
    rows_ = std::make_unique<ColumnRows>(*lines_, header_, std::move(columns.layout));
  };
  if (split_csv(line).front() == kMotiveStart) {
    read_columns(read_motive_header(*lines_, line));
  } else if (is_trc(line)) {
    read_columns(read_trc_header(*lines_, line));
  } else if (is_arena(line)) {
    refuse_with_converter(path, "in the rows of Arena and Tracking Tools", "arena");
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
  MocapFrame frame;
  while ((result.time.empty() || result.time.back() < until) && reader.next(frame)) {
    if (result.time.empty() && std::isfinite(frame.printed_time_s)) result.first_s = frame.printed_time_s;
    result.time.push_back(frame.time);
    for (const std::size_t asset : assets) result.position_m[asset].push_back(frame.poses[asset].position_m);
  }
  result.missing = remove_missing(result.time, result.position_m);
  result.anomalies = reader.anomalies();
  return result;
}

}  // namespace trilat
