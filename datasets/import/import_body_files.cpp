// SPDX-License-Identifier: MIT
#include "datasets/import/import_body_files.h"

#include <algorithm>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/import/frame_numbers.h"
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

}  // namespace trilat
