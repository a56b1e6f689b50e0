// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/mocap/mocap_take.h"
#include "datasets/mocap/mocap_text.h"

namespace trilat {

// Columns of an asset's numbers in a row; kNoColumn where it has none.
inline constexpr std::size_t kNoColumn = static_cast<std::size_t>(-1);
inline constexpr std::size_t kSlotsPerAsset = 3;
inline constexpr std::array<std::string_view, kSlotsPerAsset> kSlotNames{"position X", "position Y",
                                                                         "position Z"};
using AssetColumns = std::array<std::size_t, kSlotsPerAsset>;

struct ColumnLayout {
  std::vector<AssetColumns> columns;  // one per asset of the header
  std::size_t time_column = 1;
  std::size_t used_columns = 0;     // up to the last one that has any heading
  std::size_t written_columns = 0;  // with the empty ones a spreadsheet adds
  // Tabs stand between the cells, and the header's count of frames is a promise.
  bool tab_separated = false;
  double time_unit_s = 1.0;  // of the printed times; NaN: they say nothing
};

struct ColumnHeader {
  MocapHeader header;  // all but the first frame
  ColumnLayout layout;
};

// Reads the header rows of Motive's column format (1.2 to 1.25), of which `first_line` has been read already;
// the next line is the first of the data. Rows are known by what they say, never by their number. InputError
// with the line where something is missing or contradictory.
ColumnHeader read_motive_header(LineReader& lines, std::string_view first_line);

// Fills the assets of `header` from the rows between the keys and the row of axes ("Frame,Time,X, …"), which
// stands at `place`. Rows are known by the label in their second cell, or, without labels, by their order:
// type, name, ID, kind.
ColumnLayout read_motive_columns(const std::vector<std::vector<std::string>>& rows,
                                 const std::vector<std::string>& axes, const std::string& place,
                                 MocapHeader& header);

bool is_trc(std::string_view first_line);

// The header of a TRC as OpenSim, Pose2Sim and OpenCap write it, of which `first_line` has been read already;
// the next line is then the first of the data. The row of names says which markers there are and where; the
// other rows are asked for rate, unit and count alone. Axes stay as they are. InputError with the line where
// something is missing or contradictory.
ColumnHeader read_trc_header(LineReader& lines, std::string_view first_line);

// Reads the rows behind such a header into the take, with a frame a row and a number a column, of these
// assets alone: to the end, or through the first frame at `until`. Time is the frame number times the export
// rate; only when the header states no rate it is the printed one. Times strictly increase: rows that do not
// advance are left out and counted. InputError with the place and the asset when a number makes no sense, and
// when a file whose format promises a count ends early.
void read_rows(LineReader& lines, const ColumnLayout& layout, const std::vector<std::size_t>& assets,
               MocapTime until, MocapTake& take);

// Holds the header's rate against the times of the first rows. Times in another unit, times that count frames
// and times that stand still leave the rate as it is; where they differ otherwise by more than rounding, or
// no rate is stated, the times count. `taken_as` says so. InputError where there is neither.
void settle_trc_rate(const std::filesystem::path& path, ColumnHeader& columns);

}  // namespace trilat
