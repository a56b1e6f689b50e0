// SPDX-License-Identifier: MIT
#include "pipeline/cli/exchange_verbs.h"

#include "datasets/base/error.h"
#include "pipeline/cli/recording_verbs.h"

namespace trilat {
namespace {

// Its readers are Python now: a format is thirty lines there.
void add_import(CLI::App& app) {
  auto* verb = app.add_subcommand("import", "is not there any more; python3 -m trilat.convert does it");
  verb->allow_extras();
  verb->callback([] {
    throw InputError("import",
                     "is not there any more; PYTHONPATH=python python3 -m trilat.convert FORMAT FILE... -o "
                     "session.h5 does it (docs/other_formats.md)");
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
  add_import(app);
  add_export(app, arguments.output, code);
  add_fuse(app, arguments.fuse, code);
}

}  // namespace trilat
