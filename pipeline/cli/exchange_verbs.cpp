// SPDX-License-Identifier: MIT
#include "pipeline/cli/exchange_verbs.h"

#include "datasets/import/import_formats.h"
#include "pipeline/cli/recording_verbs.h"

namespace trilat {
namespace {

std::string format_table() {
  std::string table = "Formats:\n";
  for (const ImportFormat& format : import_formats())
    table += "  " + std::string(format.name) + std::string(14 - std::string(format.name).size(), ' ') +
             format.what + "\n";
  return table;
}

void add_import(CLI::App& app, ImportArguments& i, int& code) {
  auto* verb = app.add_subcommand("import", "somebody else's recording to a session");
  verb->add_option("format", i.format, "one of those below")->required();
  verb->add_option("files", i.files, "the recording")->required();
  verb->add_option("-o,--output", i.output, "session.h5")->required();
  verb->add_option("--rate-hz", i.rate_hz, "frames a second, where the files have no time stamps")
      ->check(CLI::Range(0.1, 1000.0));
  verb->add_option("--depth-unit-mm", i.depth_unit_mm,
                   "png: what a value of 1 means; 1 for Kinect v2 and NTU, 0.2 for TUM")
      ->check(CLI::Range(1e-4, 1e3));
  verb->add_option("--timestamps", i.timestamps,
                   "png: file with one time in seconds a line, in the order of the names");
  verb->add_flag("--time-from-name", i.time_from_name,
                 "png: the last number in a name is its time in seconds");
  verb->add_option("--compression", i.compression, "of depth: blosc, deflate, none")
      ->check(CLI::IsMember({"blosc", "deflate", "none"}))
      ->capture_default_str();
  add_force(*verb, i.force);
  add_json(*verb, i.json);
  verb->footer(
      format_table() +
      "\nExit code 1: rows were left out, and it says how many.\n"
      "Example: trilat import ntu S001C001P001R001A001.skeleton S001C002P001R001A001.skeleton -o session.h5");
  verb->callback([&] {
    end_in_order();
    code = import_session(i);
  });
}

void add_export(CLI::App& app, ExportArguments& e, int& code) {
  auto* verb = app.add_subcommand("export", "bodies of a session, or tracks of results, for other programs");
  verb->add_option("format", e.format,
                   "csv: one row a frame, body and joint, or of results one a joint and method; trc: "
                   "OpenSim's markers")
      ->required()
      ->check(CLI::IsMember({"csv", "trc"}));
  verb->add_option("input", e.input, "session.h5; for csv a results folder too")->required();
  verb->add_option("-o,--output", e.output, "the file; trc with several bodies: NAME-ID.trc each")
      ->required();
  verb->add_option("--calibration", e.calibration,
                   "calibration.json: positions in its world instead of in the sensor's frame");
  verb->add_option("--sensor", e.sensor, "trc: of which sensor, when there are several");
  verb->add_option("--body", e.body, "trc: only the body with this tracking id");
  verb->add_option("--unit", e.unit, "trc: mm or m")
      ->check(CLI::IsMember({"mm", "m"}))
      ->capture_default_str();
  add_force(*verb, e.force);
  add_json(*verb, e.json);
  verb->footer("Example: trilat export trc session.h5 --sensor k1 -o walk.trc");
  verb->callback([&] {
    end_in_order();
    code = export_recording(e);
  });
}

void add_fuse(CLI::App& app, FuseArguments& f, int& code) {
  auto* verb =
      app.add_subcommand("fuse", "one person's joints from all sensors of a session, without OptiTrack");
  verb->add_option("session", f.session, "session.h5 of several calibrated sensors")->required();
  verb->add_option("--calibration", f.calibration, "calibration.json of its sensors")->required();
  verb->add_option("-o,--output", f.output,
                   "walk.trc (OpenSim's markers), walk.c3d or walk.csv (with statuses and sigmas)")
      ->required();
  verb->add_option("--method", f.method,
                   "any method of a study, with its default settings; range_bearing takes "
                   "its sigmas from the disagreement of the sensors")
      ->capture_default_str();
  verb->add_option("--sensor", f.sensor, "single: which one");
  verb->add_option("--rate-hz", f.rate_hz, "instants a second")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  add_force(*verb, f.force);
  add_json(*verb, f.json);
  verb->footer("Example: trilat fuse session.h5 --calibration calibration.json -o walk.trc");
  verb->callback([&] {
    end_in_order();
    code = fuse(f);
  });
}

}  // namespace

void add_exchange_verbs(CLI::App& app, ExchangeArguments& arguments, int& code) {
  add_import(app, arguments.import, code);
  add_export(app, arguments.output, code);
  add_fuse(app, arguments.fuse, code);
}

}  // namespace trilat
