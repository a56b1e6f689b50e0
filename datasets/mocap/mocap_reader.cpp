// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_reader.h"

#include <string>

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
    throw InputError(
        place,
        "the file begins with data and has no header, so that unit, rate and names are "
        "unknown; when it is Motive's, export it again with the header switched on. Bodies of a Kinect are a "
        "session's: `trilat import` reads them");
  if (line.starts_with("NO_OF_") || line.starts_with("FILE_VERSION"))
    throw InputError(place,
                     "Qualisys' TSV is not read any more; export C3D from Qualisys Track Manager instead");
  if (line.starts_with("Format Version;"))
    throw InputError(place, "the cells are separated by semicolons; save the file with commas");
  if (line.starts_with("\xFF\xFE") || line.starts_with("\xFE\xFF"))
    throw InputError(place, "the text is UTF-16; save the file as UTF-8");
  throw InputError(place,
                   "this is no motion capture that can be read; known are Motive's CSV, which begins with "
                   "\"Format Version,1.2…\", the rows of Arena and Tracking Tools (\"comment,\"), TRC "
                   "(\"PathFileType\") and C3D");
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

}  // namespace trilat
