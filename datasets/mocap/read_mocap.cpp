// SPDX-License-Identifier: MIT
#include "datasets/mocap/read_mocap.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/text_output.h"
#include "datasets/mocap/column_header.h"
#include "datasets/mocap/missing_positions.h"

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

// How files of other systems begin, and what to do with them.
struct OtherFormat {
  std::string_view begins;
  const char* text;
};
constexpr const char* kHeaderIsMissing =
    "is Motive's CSV without its first rows, which state unit, rate and names; export it again with the "
    "header "
    "switched on, and keep all rows";
constexpr OtherFormat kOtherFormats[] = {
    {"NO_OF_", "is Qualisys' TSV, which is not read; export C3D from Qualisys Track Manager instead"},
    {"FILE_VERSION", "is Qualisys' TSV, which is not read; export C3D from Qualisys Track Manager instead"},
    {"Trajectories", "is a CSV of Vicon Nexus, which is not read; export C3D or TRC instead"},
    {"Model Outputs", "is a CSV of Vicon Nexus, which is not read; export C3D or TRC instead"},
    {"Devices", "is a CSV of Vicon Nexus, which is not read; export C3D or TRC instead"},
    {"Kaydara FBX", "is FBX, which is not read; export positions instead, as C3D, TRC or CSV"},
    {"HIERARCHY", "is BVH, whose joints are angles; export positions instead, as TRC or CSV"},
    {"Coordinates", "is a motion of OpenSim, whose joints are angles; write the markers as TRC instead"},
    {"<?xml", "is XML, such as Xsens' MVNX; export positions instead, as C3D, TRC or CSV"},
    {"Format Version;", "has semicolons between its cells; save the file with commas"},
    {"Format Version\t", "has tabs between its cells; save the file with commas"},
    {",Type,", kHeaderIsMissing},
    {"Frame,Time (Seconds)", kHeaderIsMissing}};
// The endings of such files, and what to do with them.
struct OtherEnding {
  std::string_view ending;
  const char* text;
};
constexpr OtherEnding kOtherEndings[] = {
    {".sto", "is a table of OpenSim, which is not read; write the markers as TRC instead"},
    {".mot", "is a motion of OpenSim, whose joints are angles; write the markers as TRC instead"},
    {".asf", "is a skeleton of Acclaim, whose joints are angles; export positions instead, as TRC or CSV"},
    {".amc", "is a motion of Acclaim, whose joints are angles; export positions instead, as TRC or CSV"},
    {".skeleton", "is a .skeleton, as of NTU RGB+D; `python3 -m trilat.convert ntu` makes a session of it"}};
constexpr const char* kKnownFormats =
    "is neither motion capture (Motive's CSV, which begins with \"Format Version,1.2\", or TRC) nor a CSV of "
    "joints, whose first row is time_s,joint,x_m,y_m,z_m";

// Three columns a joint: "time,nose_x,nose_y,nose_z".
bool is_wide_table(const std::vector<std::string>& names) {
  std::size_t triples = 0;
  for (std::size_t c = 0; c + 2 < names.size(); ++c) {
    const auto ends_as = [&](std::size_t column, char lower) {
      const std::string& name = names[column];
      return name.size() > 1 && (name.back() | 0x20) == lower &&
             name.substr(0, name.size() - 1) == names[c].substr(0, names[c].size() - 1);
    };
    triples += ends_as(c, 'x') && ends_as(c + 1, 'y') && ends_as(c + 2, 'z');
  }
  return triples > 0;
}

[[noreturn]] void refuse_json(const std::filesystem::path& path, const std::string& place) {
  std::string begin(std::size_t{1} << 20, '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  const auto has = [&](const char* key) { return begin.find(key) != std::string::npos; };
  if (has("\"pose_keypoints_2d\""))
    throw InputError(
        place,
        "is JSON of OpenPose, whose key points are pixels of one picture; make positions of several cameras' "
        "key points, as Pose2Sim does, and give its TRC");
  if (has("\"joint_names\""))
    throw InputError(place,
                     "is JSON, and no motion capture; bodies of a Kinect belong into a session: `python3 -m "
                     "trilat.convert azure-kinect` makes one of offline_processor's JSON");
  throw InputError(
      place,
      "is JSON, and no motion capture; write a row for each time and joint instead, with the columns "
      "time_s,joint,x_m,y_m,z_m");
}

[[noreturn]] void refuse_file(const std::filesystem::path& path, std::string_view line,
                              const std::string& place) {
  for (const OtherFormat& format : kOtherFormats)
    if (line.starts_with(format.begins)) throw InputError(place, format.text);
  if (line.starts_with('{') || line.starts_with('[')) refuse_json(path, place);
  if (const std::string_view kind = foreign_kind(line); !kind.empty())
    throw InputError(
        place, std::string(kind) + (kind.find("HDF5") == std::string_view::npos
                                        ? ""
                                        : "; `trilat fuse` writes the joints of a session as TRC or CSV"));
  if (line.size() > 1 && (line[0] == '\0') != (line[1] == '\0'))
    throw InputError(place, "is text in UTF-16; save the file as UTF-8");
  for (const OtherEnding& format : kOtherEndings)
    if (lower_extension(path) == format.ending) throw InputError(place, format.text);
  if (line.find('\0') != std::string_view::npos)
    throw InputError(place, "is a binary file of an unknown format; write positions as CSV or TRC");
  if (is_numbers_only(line))
    throw InputError(place,
                     "the file begins with data and has no header, so that unit, rate and names are unknown; "
                     "when it is Motive's, export it again with the header switched on. Bodies of a Kinect "
                     "belong into a session: `python3 -m trilat.convert` makes one");
  constexpr std::string_view kSeparators = ";\t";
  for (const char separator : kSeparators)
    if (line.find(separator) != std::string_view::npos && line.find("time") != std::string_view::npos)
      throw InputError(place, fmt::format("has {} between its cells; save the file with commas",
                                          separator == ';' ? "semicolons" : "tabs"));
  refuse_lone_returns(line, place);
  throw InputError(place, kKnownFormats);
}

[[noreturn]] void refuse_wide_table(const std::vector<std::string>& names, const std::string& place) {
  throw InputError(
      place, fmt::format("has three columns a joint ({}, ...); write a row for each time and joint "
                         "instead, with the columns time_s,joint,x_m,y_m,z_m",
                         fmt::join(std::span(names).first(std::min<std::size_t>(4, names.size())), ", ")));
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

// Whether the first row of a file is one that Arena, Tracking Tools or Motive before version 1.2 wrote; a
// table may have a column "frame".
bool is_arena(std::string_view line) {
  constexpr std::string_view kRows[] = {"comment",    "info",      "righthanded",
                                        "lefthanded", "trackable", "rigidbody"};
  const std::vector<std::string> cells = split_csv(line);
  std::int64_t frame = 0;
  return std::ranges::find(kRows, cells.front()) != std::end(kRows) ||
         (cells.front() == "frame" && cells.size() > 1 && parse_integer(cells[1], frame));
}

// The line that makes Motive's CSV of a file in another format.
[[noreturn]] void refuse_with_converter(const std::filesystem::path& path, const char* what,
                                        const char* format) {
  const bool is_c3d = format == std::string_view("c3d");
  const auto output = std::filesystem::path(path).replace_extension(is_c3d ? ".csv" : ".motive.csv");
  throw InputError(path.string(), fmt::format("is {}; python3 -m trilat.convert {} {} -o {}", what, format,
                                              shell_word(path.string()), shell_word(output.string())));
}

// The header of the format that the first line says.
ColumnHeader read_header(const std::filesystem::path& path, LineReader& lines) {
  std::string_view line;
  if (!lines.next(line)) throw InputError(lines.place(), "the file is empty");
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  const std::vector<std::string> names = split_csv(line);
  ColumnHeader columns;
  if (names.front() == kMotiveStart || is_trc(line) || is_wide_table(names))
    refuse_lone_returns(line, lines.place());
  if (names.front() == kMotiveStart) {
    columns = read_motive_header(lines, line);
  } else if (is_trc(line)) {
    columns = read_trc_header(lines, line);
    settle_trc_rate(path, columns);
  } else if (is_wide_table(names)) {
    refuse_wide_table(names, lines.place());
  } else if (is_arena(line)) {
    refuse_with_converter(path, "in the rows of Arena and Tracking Tools", "arena");
  } else {
    refuse_file(path, line, lines.place());
  }
  for (std::size_t i = 0; i < columns.header.assets.size(); ++i)
    columns.header.assets[i].column = std::ranges::min(columns.layout.columns[i]) + 1;
  return columns;
}

}  // namespace

bool is_mocap_file(const std::filesystem::path& path) {
  if (is_c3d(path)) return true;
  LineReader lines(path, MocapPart{}.block_bytes);
  std::string_view line;
  if (!lines.next(line)) return false;
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  return line.starts_with(kMotiveStart) || is_trc(line) ||
         (is_arena(line) && !is_wide_table(split_csv(line)));
}

MocapHeader read_mocap_header(const std::filesystem::path& path) {
  if (is_c3d(path)) refuse_with_converter(path, "C3D", "c3d");
  LineReader lines(path, MocapPart{}.block_bytes);
  return read_header(path, lines).header;
}

MocapTake read_mocap(const std::filesystem::path& path, const MocapPart& part) {
  if (is_c3d(path)) refuse_with_converter(path, "C3D", "c3d");
  LineReader lines(path, part.block_bytes);
  ColumnHeader columns = read_header(path, lines);
  MocapTake take;
  take.header = std::move(columns.header);
  std::vector<std::size_t> assets(take.header.assets.size());
  std::iota(assets.begin(), assets.end(), std::size_t{0});
  assets = part.assets.value_or(assets);
  take.position_m.resize(take.header.assets.size());
  if (part.until == MocapPart{}.until) {
    constexpr std::int64_t kMaxCount = 10'000'000;  // whatever the header says
    const auto frames = static_cast<std::size_t>(
        std::clamp<std::int64_t>(take.header.total_exported_frames.value_or(0), 0, kMaxCount));
    take.time.reserve(frames);
    take.frame.reserve(frames);
    for (const std::size_t asset : assets) take.position_m.at(asset).reserve(frames);
  }
  read_rows(lines, columns.layout, assets, part.until, take);
  if (!take.header.taken_as.empty()) take.taken_as.push_back(take.header.taken_as);
  return take;
}

MocapTake read_positions(const std::filesystem::path& path, const MocapPart& part) {
  MocapTake take = read_mocap(path, part);
  take.missing = remove_missing(take.time, take.position_m);
  return take;
}

}  // namespace trilat
