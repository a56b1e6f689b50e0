// SPDX-License-Identifier: MIT
#include "datasets/mocap/optitrack_csv_reader.h"

#include <cmath>

#include "datasets/base/error.h"
#include "datasets/mocap/optitrack_format.h"

namespace trilat {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr double kFarthest_m = 1000.0;

std::unique_ptr<OptitrackFormat> format_of(CsvLines& lines) {
  std::string_view line;
  if (!lines.next(line))
    throw InputError(lines.path() + ":1", "is empty; an OptiTrack CSV export is expected");
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  const std::string first = line.size() < 4096 ? csv_fields(line)[0] : "";
  if (first == "Format Version") return column_format(lines, line);
  if (first == "comment" || first == "righthanded" || first == "lefthanded" || first == "info")
    return row_format(lines, line);
  double number = 0.0;
  if (first == "Frame" || parse_cell(first, number) == CellKind::number)
    throw InputError(
        lines.place(),
        "has data but no header, so its unit, rate and assets are unknown; export again with the header");
  throw InputError(
      lines.place(),
      "does not begin as an OptiTrack CSV export does (\"Format Version,…\", or rows of \"comment\", "
      "\"righthanded\" or \"info\")");
}

}  // namespace

double checked_metres(double value, double metres_per_unit, const CsvLines& lines, const std::string& asset) {
  const double metres = value * metres_per_unit;
  if (std::abs(metres) > kFarthest_m)
    throw InputError(lines.place(), "puts \"" + asset + "\" " + std::to_string(metres) +
                                        " m from the origin; is the length unit in the header right?");
  return metres;
}

void make_right_handed(MocapPose& pose) {
  pose.position_m.z() = -pose.position_m.z();
  pose.rotation.x() = -pose.rotation.x();
  pose.rotation.y() = -pose.rotation.y();
}

struct OptitrackCsvReader::State {
  CsvLines lines;
  std::unique_ptr<OptitrackFormat> format;
  State(const std::filesystem::path& path, std::size_t block_bytes)
      : lines(path, block_bytes), format(format_of(lines)) {}
};

OptitrackCsvReader::OptitrackCsvReader(const std::filesystem::path& path, const OptitrackReadOptions& options)
    : state_(std::make_unique<State>(path, options.block_bytes)) {}

OptitrackCsvReader::~OptitrackCsvReader() = default;
OptitrackCsvReader::OptitrackCsvReader(OptitrackCsvReader&&) noexcept = default;

const MocapHeader& OptitrackCsvReader::header() const { return state_->format->header; }
const MocapAnomalies& OptitrackCsvReader::anomalies() const { return state_->format->anomalies; }
void OptitrackCsvReader::read_only(const std::vector<std::size_t>& assets) {
  state_->format->read_only(assets);
}
bool OptitrackCsvReader::next(MocapFrame& frame) { return state_->format->next(frame); }

MocapTake read_optitrack_csv(const std::filesystem::path& path, const OptitrackReadOptions& options) {
  OptitrackCsvReader reader(path, options);
  MocapTake take;
  take.header = reader.header();
  for (MocapFrame frame; reader.next(frame);) take.frames.push_back(frame);
  take.anomalies = reader.anomalies();
  return take;
}

}  // namespace trilat
