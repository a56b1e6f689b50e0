// SPDX-License-Identifier: MIT
#include "pipeline/cli/recording_verbs.h"

#include "datasets/base/error.h"
#include "recorders/open_source.h"

namespace trilat {
namespace {

void add_record(CLI::App& app, RecordArguments& r, int& code) {
  auto* verb = app.add_subcommand("record", "sensors to a session; Ctrl-C ends it in order");
  verb->add_option("--source", r.sources, source_help() + "; may be repeated");
  auto* listen = verb->add_option(
      "--listen", r.listen, "HOST:PORT where agents on other computers connect (`trilat-agent --help`)");
  verb->add_option("--agents", r.agents, "the recording begins when so many are there")
      ->check(CLI::Range(1, 64))
      ->needs(listen)
      ->capture_default_str();
  verb->add_option("--wait-s", r.wait_s, "how long to wait for them")
      ->check(CLI::PositiveNumber)
      ->needs(listen)
      ->capture_default_str();
  verb->add_option("--keys", r.keys, "server.pem, as made by `trilat-agent keys`")->needs(listen);
  verb->add_flag("--plain-text", r.plain_text, "without keys: let everybody on the way read and write")
      ->needs(listen);
  verb->add_option("-o,--output", r.output, "session.h5")->required();
  verb->add_option("--duration-s", r.duration_s, "ends after so long; 0: when somebody stops it")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb->add_option("--compression", r.compression,
                   "of depth: blosc (Zstandard, best; h5py needs hdf5plugin), deflate (any reader), none")
      ->check(CLI::IsMember({"blosc", "deflate", "none"}))
      ->capture_default_str();
  verb->add_option("--queue-mb", r.queue_mb,
                   "memory for frames that wait for the disk; beyond, they are lost")
      ->check(CLI::Range(4, 1 << 16))
      ->capture_default_str();
  verb->add_option("--reserve-mb", r.reserve_mb, "the recording ends in order when the disk has less left")
      ->check(CLI::Range(0, 1 << 20))
      ->capture_default_str();
  verb->add_option("--workers", r.workers, "threads that compress")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  verb->add_flag("--preview", r.preview, "shows the skeletons on the terminal");
  verb->add_option("--calibration", r.calibration,
                   "with --preview: poses of the sensors; shows the person whom all see together, too");
  verb->add_option("--truth", r.truth,
                   "of a synthetic source: folder for the OptiTrack export, true poses and a campaign.json");
  add_force(*verb, r.force);
  add_json(*verb, r.json);
  verb->footer(
      "Examples:\n"
      "  trilat record --source synthetic:4 --duration-s 20 -o session.h5\n"
      "  trilat record --listen 0.0.0.0:7345 --agents 4 --keys keys/server.pem -o session.h5");
  verb->callback([&] {
    end_in_order();
    code = record_session(r);
  });
}

void add_info(CLI::App& app, InfoArguments& i, int& code) {
  auto* verb = app.add_subcommand("info", "what is in a session");
  verb->add_option("session", i.session, "session.h5")->required();
  auto* follow = verb->add_flag("--follow", i.follow, "a line a second while it is being recorded");
  add_json(*verb, i.json);
  verb->get_option("--json")->excludes(follow);
  verb->callback([&] {
    if (i.follow) end_in_order();
    code = info(i);
  });
}

void add_verify(CLI::App& app, VerifyArguments& v, int& code) {
  auto* verb = app.add_subcommand("verify", "read everything in a session and say what is odd");
  verb->add_option("session", v.session, "session.h5")->required();
  verb->add_flag("--skip-depth", v.skip_depth, "do not decompress the depth frames");
  add_json(*verb, v.json);
  verb->callback([&] { code = verify(v); });
}

void add_recover(CLI::App& app, RecoverArguments& r, int& code) {
  auto* verb = app.add_subcommand("recover", "save what a killed recorder left, into a new session");
  verb->add_option("session", r.session, "session.h5, or session.h5.partial")->required();
  verb->add_option("-o,--output", r.output, "the new session; by default the name without .partial");
  add_force(*verb, r.force);
  add_json(*verb, r.json);
  verb->callback([&] {
    end_in_order();
    code = recover(r);
  });
}

}  // namespace

void add_json(CLI::App& verb, bool& json) {
  verb.add_flag("--json", json, "one JSON document on stdout, and nothing else there");
}

void add_force(CLI::App& verb, bool& force) {
  verb.add_flag("--force", force,
                "replace what stands under the output's name, whoever wrote it; never an input");
}

void add_gone(CLI::App& verb, const std::string& option, const std::string& instead) {
  verb.add_option_function<std::string>(option,
                                        [option, instead](const std::string&) {
                                          throw InputError(option, "is not there any more; " + instead);
                                        })
      ->group("");  // in no help
}

void add_recording_verbs(CLI::App& app, RecordingArguments& arguments, int& code) {
  add_record(app, arguments.record, code);
  add_info(app, arguments.info, code);
  add_verify(app, arguments.verify, code);
  add_recover(app, arguments.recover, code);
}

}  // namespace trilat
