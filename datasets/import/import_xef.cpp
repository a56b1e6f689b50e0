// SPDX-License-Identifier: MIT
#include "datasets/import/import_xef.h"

#include "datasets/base/error.h"
#include "datasets/import/import_session.h"
#include "datasets/import/joint_cells.h"

namespace trilat {
namespace {

constexpr const char* kAssumed =
    "The file holds no absolute time and no intrinsics that could be read: those of a typical Kinect v2 are "
    "written. This importer has not yet been run on a real file.";

void refuse_what_is_no_use(const XefReader& reader, const XefSurvey& survey, const std::string& path) {
  if (survey.depth_frames + survey.body_frames > 0) return;
  if (reader.has_raw_infrared())
    throw InputError(path,
                     "is a raw capture (.xrf), from which depth has yet to be computed; play it in Kinect "
                     "Studio and record depth and bodies");
  throw InputError(path, "holds neither depth nor bodies");
}

SessionHeader header_of(const XefSurvey& survey) {
  SensorDescription sensor;
  sensor.name = "k1";
  sensor.source = "import xef";
  sensor.tick_ns = kImportTickNs;
  sensor.has_depth = survey.depth_frames > 0;
  SessionHeader header;
  header.note = kAssumed;
  header.sensors.push_back(sensor);
  return header;
}

// Reads frames into a session, with the buffers for them.
class XefImport {
 public:
  XefImport(const XefReader& reader, ImportSession& session)
      : reader_(reader), session_(session), depth_mm_(kDepthPixels), bodies_(xef::kBodyFrameBytes) {}

  void add(const XefEvent& event) {
    const std::string place = reader_.place(event);
    try {
      event.kind == xef::StreamKind::depth ? add_depth(event, place) : add_bodies(event, place);
    } catch (const TornRow& row) {
      count_torn(session_.report(0).left_out, place, row);
    }
  }

 private:
  void add_depth(const XefEvent& event, const std::string& place) {
    reader_.read_payload(event, std::as_writable_bytes(std::span(depth_mm_)));
    session_.add_depth(0, event.header.ticks, event.frame_number, depth_mm_, place);
  }
  void add_bodies(const XefEvent& event, const std::string& place) {
    reader_.read_payload(event, bodies_);
    xef::BodyPayload payload = xef::body_payload(bodies_);
    for (const Body& body : payload.bodies) check_positions(body, place);
    session_.add_bodies(
        0, {event.header.ticks, event.frame_number, payload.floor_plane, std::move(payload.bodies), {}},
        place);
  }

  const XefReader& reader_;
  ImportSession& session_;
  std::vector<std::uint16_t> depth_mm_;
  std::vector<std::byte> bodies_;
};

}  // namespace

XefSurvey survey_xef(XefReader& reader) {
  XefSurvey survey;
  for (XefEvent event; reader.next(event);)
    ++(event.kind == xef::StreamKind::depth ? survey.depth_frames : survey.body_frames);
  return survey;
}

ImportReport import_xef(const std::vector<std::filesystem::path>& files, const std::filesystem::path& output,
                        const ImportOptions& options) {
  if (files.size() != 1)
    throw InputError(
        files.empty() ? "FILE" : files[1].string(),
        files.empty() ? "is missing"
                      : "is a second file; recordings share no clock, so each becomes a session of its own");
  const std::string path = files[0].string();
  XefReader first(files[0]);
  const XefSurvey survey = survey_xef(first);
  refuse_what_is_no_use(first, survey, path);
  ImportSession session(output, header_of(survey), options.compression);
  ImportedSensor& report = session.report(0);
  report.file = path;
  XefReader reader(files[0]);
  XefImport import(reader, session);
  const auto size = static_cast<double>(std::filesystem::file_size(files[0]));
  for (XefEvent event; reader.next(event);) {
    import.add(event);
    if (options.progress) options.progress(static_cast<double>(reader.bytes_read()) / size);
  }
  report.skipped_events = reader.skipped_events();
  report.skipped_bytes = reader.skipped_bytes();
  return session.finish();
}

}  // namespace trilat
