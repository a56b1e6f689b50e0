// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "datasets/mocap/csv_lines.h"
#include "datasets/mocap/mocap_take.h"

namespace trilat {

// One of the two families of exports, behind OptitrackCsvReader. Made with the lines positioned behind the
// first one.
class OptitrackFormat {
 public:
  virtual ~OptitrackFormat() = default;
  virtual void read_only(const std::vector<std::size_t>& assets) = 0;
  virtual bool next(MocapFrame& frame) = 0;

  MocapHeader header;
  MocapAnomalies anomalies;
};

std::unique_ptr<OptitrackFormat> column_format(CsvLines& lines, std::string_view first_line);
std::unique_ptr<OptitrackFormat> row_format(CsvLines& lines, std::string_view first_line);

// A position in metres, checked: farther than 1 km from the origin is no motion capture.
double checked_metres(double value, double metres_per_unit, const CsvLines& lines, const std::string& asset);
// A right-handed pose from a left-handed one: z turned round.
void make_right_handed(MocapPose& pose);

}  // namespace trilat
