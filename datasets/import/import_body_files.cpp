// SPDX-License-Identifier: MIT
#include "datasets/import/import_body_files.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/import/import_session.h"
#include "datasets/import/joint_cells.h"

namespace trilat {

namespace {

enum class Read { frame, torn, end };

// The next frame, checked; a torn one is counted.
Read next_frame(BodyFileReader& reader, FileFrame& frame, LeftOut& left_out) {
  try {
    if (!reader.next(frame)) return Read::end;
    for (const Body& body : frame.bodies) check_positions(body, reader.place());
    if (frame.bodies.size() > kMaxBodies)
      throw TornRow{
          fmt::format("has {} bodies; a Kinect tracks at most {}", frame.bodies.size(), kMaxBodies)};
    return Read::frame;
  } catch (const TornRow& row) {
    count_torn(left_out, reader.place(), row);
    return Read::torn;
  }
}

// The share done of all files, each read twice.
class Share {
 public:
  Share(const std::vector<SensorFile>& files, const ImportOptions& options) : options_(options) {
    for (const SensorFile& file : files) {
      std::error_code error;
      const auto size = std::filesystem::file_size(file.path, error);
      if (!error) total_bytes_ += 2 * size;
    }
  }
  void at(std::uint64_t bytes) const {
    if (options_.progress && total_bytes_ > 0)
      options_.progress(
          std::min(1.0, static_cast<double>(before_ + bytes) / static_cast<double>(total_bytes_)));
  }
  void next_reading(const std::filesystem::path& path) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    if (!error) before_ += size;
  }

 private:
  const ImportOptions& options_;
  std::uint64_t total_bytes_ = 0, before_ = 0;
};

void import_one(BodyFileReader& reader, ImportSession& session, std::size_t sensor, const Share& share) {
  FileFrame frame;
  std::int64_t count = 0;
  for (Read read; (read = next_frame(reader, frame, session.report(sensor).left_out)) != Read::end;) {
    if (++count % 256 == 0) share.at(reader.bytes_read());
    if (read == Read::frame) session.add_bodies(sensor, frame, reader.place());
  }
}

std::string note_of(const BodyFileFormat& format, const std::vector<BodyFileSurvey>& surveys) {
  const auto fitted =
      std::count_if(surveys.begin(), surveys.end(), [](const auto& s) { return s.fitted.has_value(); });
  return format.assumed +
         (fitted == static_cast<std::ptrdiff_t>(surveys.size())
              ? " Intrinsics: fitted to the joints' depth pixels, without distortion."
              : " Intrinsics: those of a typical Kinect v2 where the files do not show their own.");
}

SessionHeader header_of(const BodyFileFormat& format, const std::vector<SensorFile>& files,
                        const std::vector<BodyFileSurvey>& surveys, const ImportOptions& options) {
  SessionHeader header;
  header.started_utc = format.started_utc;
  header.note = note_of(format, surveys);
  for (std::size_t i = 0; i < files.size(); ++i) {
    SensorDescription sensor;
    sensor.name = files[i].sensor;
    sensor.source = "import " + format.name;
    sensor.tick_ns = kImportTickNs;
    sensor.nominal_rate_hz = options.rate_hz.value_or(format.nominal_rate_hz);
    if (surveys[i].fitted) sensor.intrinsics = surveys[i].fitted->intrinsics;
    header.sensors.push_back(sensor);
  }
  return header;
}

constexpr double kFewestJoints = 200.0;
constexpr double kSmallestSpread = 0.03;  // standard deviation of X/Z and Y/Z
constexpr double kLargestRms_px = 1.0;

struct Line {
  double offset = 0.0, slope = 0.0, variance = 0.0, spread = 0.0;
};

Line line_of(const LineSums& sums) {
  const double mean_x = sums.x / sums.count, mean_y = sums.y / sums.count;
  const double var_x = sums.xx / sums.count - mean_x * mean_x;
  const double cov = sums.xy / sums.count - mean_x * mean_y;
  const double var_y = sums.yy / sums.count - mean_y * mean_y;
  const double slope = var_x > 0.0 ? cov / var_x : 0.0;
  return {mean_y - slope * mean_x, slope, std::max(0.0, var_y - slope * cov),
          std::sqrt(std::max(0.0, var_x))};
}

}  // namespace

BodyFileSurvey survey_body_file(BodyFileReader& reader, const std::string& name,
                                const std::function<void(std::uint64_t)>& progress) {
  BodyFileSurvey survey;
  IntrinsicsFit fit;
  FileFrame frame;
  std::int64_t count = 0;
  for (Read read; (read = next_frame(reader, frame, survey.left_out)) != Read::end;) {
    if (progress && ++count % 256 == 0) progress(reader.bytes_read());
    if (read == Read::torn) continue;
    ++survey.frames;
    for (std::size_t b = 0; b < frame.depth_px.size(); ++b) fit.add(frame.bodies.at(b), frame.depth_px[b]);
  }
  if (survey.frames == 0)
    throw InputError(
        name, survey.left_out.first.empty()
                  ? "holds no frame"
                  : "holds no frame that can be read; is it in this format? First: " + survey.left_out.first);
  survey.fitted = fit.solve();
  return survey;
}

ImportReport import_body_files(const BodyFileFormat& format, const std::vector<SensorFile>& files,
                               const std::filesystem::path& output, const ImportOptions& options) {
  Share share(files, options);
  std::vector<BodyFileSurvey> surveys;
  for (const SensorFile& file : files) {
    const auto reader = format.open(file.path);
    surveys.push_back(
        survey_body_file(*reader, file.path.string(), [&](std::uint64_t bytes) { share.at(bytes); }));
    share.next_reading(file.path);
  }
  ImportSession session(output, header_of(format, files, surveys, options), options.compression);
  for (std::size_t i = 0; i < files.size(); ++i) {
    session.report(i).file = files[i].path.string();
    if (surveys[i].fitted) session.report(i).intrinsics_rms_px = surveys[i].fitted->rms_px;
    const auto reader = format.open(files[i].path);
    import_one(*reader, session, i, share);
    share.next_reading(files[i].path);
  }
  return session.finish();
}

void LineSums::add(double ratio, double pixel) {
  count += 1.0;
  x += ratio;
  y += pixel;
  xx += ratio * ratio;
  xy += ratio * pixel;
  yy += pixel * pixel;
}

void IntrinsicsFit::add(const Body& body, const JointPixels& depth_px) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto& p = body.position_m[j];
    const auto [u, v] = depth_px[j];
    const bool inside = u >= 0.0 && u < kDepthWidth && v >= 0.0 && v < kDepthHeight;
    if (body.tracking_state[j] == 0 || p[2] < 0.3f || !inside) continue;
    column_.add(static_cast<double>(p[0]) / static_cast<double>(p[2]), u);
    row_.add(static_cast<double>(p[1]) / static_cast<double>(p[2]), v);
  }
}

std::optional<FittedIntrinsics> IntrinsicsFit::solve() const {
  if (column_.count < kFewestJoints) return {};
  const Line column = line_of(column_), row = line_of(row_);
  if (!(std::min(column.spread, row.spread) >= kSmallestSpread)) return {};
  FittedIntrinsics fitted;
  fitted.intrinsics = {.fx_px = column.slope,
                       .fy_px = -row.slope,
                       .cx_px = column.offset,
                       .cy_px = row.offset,
                       .k1 = 0.0,
                       .k2 = 0.0,
                       .k3 = 0.0};
  fitted.rms_px = std::sqrt(0.5 * (column.variance + row.variance));
  if (!(fitted.rms_px <= kLargestRms_px) || !implausibility_of(fitted.intrinsics).empty()) return {};
  return fitted;
}

}  // namespace trilat
