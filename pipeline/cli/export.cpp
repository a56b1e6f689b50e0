// SPDX-License-Identifier: MIT
// `trilat export`.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/export/samples_csv.h"
#include "datasets/export/session_csv.h"
#include "datasets/export/session_trc.h"
#include "datasets/take/campaign.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/exchange_verbs.h"
#include "pipeline/cli/terminal/progress.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

void refuse(bool given, const char* option, const char* why) {
  if (given) throw InputError(option, why);
}

void check_export(const ExportArguments& a, const std::filesystem::path& output, OutputKind kind) {
  check_output({output, kind, {a.input, a.calibration}, a.force});
}

Json export_trc(const ExportArguments& a, const ExportOptions& frame) {
  const SessionReader session(a.input);
  Json files = Json::array();
  const auto check = [&](const std::filesystem::path& file) { check_export(a, file, OutputKind::trc); };
  for (const TrcFile& file :
       export_session_trc(session, a.output, {frame, a.sensor, a.body, a.unit == "mm", check}))
    files.push_back({{"file", file.path.string()}, {"tracking_id", file.tracking_id}, {"rows", file.rows}});
  return files;
}

Json export_csv(const ExportArguments& a, const ExportOptions& frame) {
  refuse(!a.sensor.empty(), "--sensor", "is for trc; csv holds all sensors");
  refuse(a.body.has_value(), "--body", "is for trc; csv holds all bodies");
  std::int64_t rows = 0;
  if (std::filesystem::exists(a.input / "campaign.json"))
    throw InputError(a.input.string(),
                     "is a campaign; export one of its sessions, such as " +
                         read_campaign(a.input, OutsidePaths::allowed).takes.front().session.string());
  if (std::filesystem::is_directory(a.input)) {
    refuse(frame.calibration.has_value(), "--calibration",
           "is for sessions; results are in the world already");
    check_export(a, a.output, OutputKind::samples_table);
    rows = export_samples_csv(SamplesFile::open(a.input / "samples.h5"), a.output, frame.progress);
  } else {
    check_export(a, a.output, OutputKind::session_table);
    rows = export_session_csv(SessionReader(a.input), a.output, frame);
  }
  return Json::array({{{"file", a.output.string()}, {"rows", rows}}});
}

}  // namespace

int export_recording(const ExportArguments& arguments) {
  Json files;
  {
    Progress progress("exporting " + arguments.input.filename().string());
    ExportOptions frame;
    frame.progress = [&](double share) {
      if (stop_requested()) throw Interrupted();
      progress.set(share);
    };
    if (!arguments.calibration.empty()) frame.calibration = read_calibration(arguments.calibration);
    files = arguments.format == "trc" ? export_trc(arguments, frame) : export_csv(arguments, frame);
  }
  if (arguments.json)
    fmt::print("{}\n", json_text(Json{{"from", arguments.input.string()}, {"files", files}}, 2));
  else
    for (const Json& file : files)
      fmt::print("{}: {} rows\n", file["file"].get<std::string>(), file["rows"].get<std::int64_t>());
  return kDone;
}

}  // namespace trilat
