// SPDX-License-Identifier: MIT
// `trilat export`.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/export/samples_csv.h"
#include "datasets/export/session_export.h"
#include "datasets/take/campaign.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/terminal/progress.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

struct ExportArguments {
  std::string format;
  std::filesystem::path input;  // a session, or for csv a results folder
  std::filesystem::path output;
  std::filesystem::path calibration;
  std::string sensor;
  std::optional<std::uint64_t> body;
  std::string unit = "mm";
  bool force = false;  // may replace what others wrote
  bool json = false;
};

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

}  // namespace

void add_export(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<ExportArguments>(
      app, code, "export", "bodies of a session, or tracks of results, for other programs", export_recording);
  verb.add_option("format", a.format,
                  "csv: one row a frame, body and joint, or of results one a joint and method; trc: "
                  "OpenSim's markers")
      ->required()
      ->check(CLI::IsMember({"csv", "trc"}));
  verb.add_option("input", a.input, "session.h5; for csv a results folder too")->required();
  verb.add_option("-o,--output", a.output, "the file; trc with several bodies: NAME-ID.trc each")->required();
  verb.add_option("--calibration", a.calibration,
                  "calibration.json: positions in its world instead of in the sensor's frame");
  verb.add_option("--sensor", a.sensor, "trc: of which sensor, when there are several");
  verb.add_option("--body", a.body, "trc: only the body with this tracking id");
  verb.add_option("--unit", a.unit, "trc: mm or m")->check(CLI::IsMember({"mm", "m"}))->capture_default_str();
  add_force(verb, a.force);
  add_json(verb, a.json);
  verb.footer("Example: trilat export trc session.h5 --sensor k1 -o walk.trc");
}

}  // namespace trilat
