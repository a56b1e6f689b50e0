// SPDX-License-Identifier: MIT
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <typeinfo>

#include <CLI/CLI.hpp>

#include "datasets/base/error.h"
#include "datasets/base/version.h"
#include "pipeline/cli/exchange_verbs.h"
#include "pipeline/cli/recording_verbs.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

struct AllArguments {
  MocapArguments mocap;
  SchemaArguments schema;
  SimulateArguments simulate;
  CalibrateArguments calibrate;
  MeasureTrackerArguments measure_tracker;
  RunArguments run;
  MergeArguments merge;
  ReportArguments report;
  ReproduceArguments reproduce;
  GateArguments gate;
};

void add_allow_outside(CLI::App& verb, OutsidePaths& outside, const std::string& document) {
  verb.add_flag_callback(
      "--allow-outside", [&outside] { outside = OutsidePaths::allowed; },
      "let " + document + " name files outside its own folder");
}

void add_inspection(CLI::App& app, AllArguments& a, int& code) {
  auto* mocap_verb = app.add_subcommand(
      "mocap",
      "what an OptiTrack export holds: format, rate, unit, every asset with samples, gaps, frozen stretches");
  mocap_verb->add_option("file", a.mocap.file, "CSV of Motive, Arena or Tracking Tools, TRC, or C3D")
      ->required();
  add_json(*mocap_verb, a.mocap.json);
  mocap_verb->callback([&] { code = mocap(a.mocap); });

  auto* schema_verb = app.add_subcommand(
      "schema", "JSON Schema of a document that users write, for editors that complete and check it");
  schema_verb->add_option("document", a.schema.document,
                          "study, simulation, campaign, mapping or calibration");
  schema_verb->add_flag("--markdown", a.schema.markdown, "the keys of all documents as tables");
  schema_verb->callback([&] { code = schema(a.schema); });
}

void add_calibrate(CLI::App& app, AllArguments& a, int& code) {
  auto* verb = app.add_subcommand("calibrate", "wand frames to sensor poses, with stated uncertainty");
  CalibrateArguments& c = a.calibrate;
  verb->add_option("sessions", c.sessions,
                   "session.h5 of one rig, in which the wand is held still at many places")
      ->required();
  verb->add_option("-o,--output", c.output, "calibration.json")->required();
  verb->add_option("--method", c.method,
                   "wand: all positions, refined together; bodies: a tracked person instead of a wand; "
                   "two_positions, printed: the paper's eq. 6 and 7, corrected and as printed")
      ->check(CLI::IsMember({"wand", "bodies", "two_positions", "printed"}))
      ->capture_default_str();
  verb->add_option("--ball-radius-m", c.ball_radius_m, "of the wand's ball")
      ->check(CLI::Range(0.02, 0.3))
      ->capture_default_str();
  verb->add_option(
      "--intrinsics", c.intrinsics,
      "SENSOR=FILE: an OpenCV calibration (YAML) instead of the session's intrinsics; may be repeated");
  verb->add_option("--mocap", c.mocap, "OptiTrack export of the wand: poses come out in OptiTrack's world");
  verb->add_option("--asset", c.asset, "asset of the export whose position is the ball's centre");
  verb->add_option("--mocap-start-host-ns", c.mocap_start_host_ns,
                   "what the recording's host clock showed at the export's first frame");
  verb->add_option(
          "--movement-m", c.movement_m,
          "how far the wand moved from its first place to its second, when measured: fixes the scale")
      ->check(CLI::PositiveNumber);
  verb->add_option("--movement-sigma-m", c.movement_sigma_m, "how sure that is, one standard deviation")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  verb->add_option(
          "--trajectory-axis", c.trajectory_axis,
          "two_positions, printed: which axis of the sensor (x right, y down, z depth) is the paper's "
          "y of eq. 6; without it y as printed, z (a horizontal axis) corrected")
      ->check(CLI::IsMember({"x", "y", "z"}));
  verb->add_flag("--no-depth-correction", c.no_depth_correction,
                 "do not estimate each sensor's depth offset and wiggle beside its pose");
  add_gone(*verb, "--shard", "run it whole: ten minutes of four sensors take one to two minutes");
  verb->add_option("--threads", c.threads, "how many threads; 0: one a processor")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  add_force(*verb, c.force);
  add_json(*verb, c.json);
  verb->callback([&] {
    end_in_order();
    code = calibrate(a.calibrate);
  });
}

void add_measure_tracker(CLI::App& app, AllArguments& a, int& code) {
  auto* verb = app.add_subcommand(
      "measure-tracker",
      "takes with a truth, or of several sensors -> the parameters of the simulated tracker, with intervals");
  MeasureTrackerArguments& m = a.measure_tracker;
  verb->add_option("campaigns", m.campaigns, "folders of takes; a participant is known in one of them only")
      ->required();
  verb->add_option("-o,--output", m.output,
                   "body_tracker.json; simulation.json may name it as \"body_tracker\"")
      ->required();
  add_allow_outside(*verb, m.outside, "campaign.json");
  add_force(*verb, m.force);
  add_json(*verb, m.json);
  verb->footer(
      "What the takes do not tell stays as declared and is named. Intervals are over participants; fewer "
      "than "
      "three give none.\nExample: trilat measure-tracker ui-prmd kinectmultitrack -o body_tracker.json");
  verb->callback([&] {
    end_in_order();
    code = measure_tracker(a.measure_tracker);
  });
}

void add_work(CLI::App& app, AllArguments& a, int& code) {
  auto* simulate_verb =
      app.add_subcommand("simulate", "virtual Kinects watch a generated person or a real OptiTrack take");
  simulate_verb->add_option("spec", a.simulate.spec, "simulation.json")->required();
  simulate_verb->add_option("-o,--output", a.simulate.output, "folder of the campaign")->required();
  simulate_verb->add_option("--shard", a.simulate.shard,
                            "k/n: make only part k of n, into a folder for `trilat merge`");
  add_allow_outside(*simulate_verb, a.simulate.outside, "simulation.json");
  add_force(*simulate_verb, a.simulate.force);
  add_json(*simulate_verb, a.simulate.json);
  simulate_verb->callback([&] {
    end_in_order();
    code = simulate(a.simulate);
  });

  auto* run_verb = app.add_subcommand(
      "run",
      "a study: takes x methods, a threshold sweep, calibration, clocks or an error budget -> results");
  run_verb->add_option("study", a.run.study, "study.json")->required();
  run_verb->add_option("--campaign", a.run.campaign, "folder of takes, instead of the study's own");
  run_verb->add_option("--calibration", a.run.calibration, "calibration.json, instead of the takes' own");
  run_verb->add_option("-o,--output", a.run.output, "results folder; not needed with --dry-run");
  run_verb->add_option("--threads", a.run.threads, "how many threads; 0: one a processor")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  run_verb
      ->add_option("--memory-mb", a.run.memory_mb,
                   "evaluate no more takes at once than fit into so much memory; half of what there is")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 30));
  run_verb->add_flag("--cross-check", a.run.cross_check,
                     "solve again with Ceres, report the worst difference and fail beyond the study's limit");
  run_verb->add_flag("--dry-run", a.run.dry_run, "print the plan and stop");
  run_verb->add_option("--shard", a.run.shard,
                       "k/n: compute only part k of n, into a folder for `trilat merge`");
  run_verb->add_option(
      "--reuse", a.run.reuse,
      "earlier results: what did not change since is taken from there; may be repeated. What "
      "--output holds is always asked");
  run_verb->add_flag("--fresh", a.run.fresh, "compute all again, whatever --output holds");
  add_allow_outside(*run_verb, a.run.outside, "campaign.json or simulation.json");
  add_force(*run_verb, a.run.force);
  add_json(*run_verb, a.run.json);
  run_verb->add_flag("--tables", a.run.tables, "accuracy: print all tables, as Markdown");
  run_verb->callback([&] {
    end_in_order();
    code = run(a.run);
  });

  auto* merge_verb =
      app.add_subcommand("merge", "the parts that --shard has written -> what one run would have");
  merge_verb->add_option("parts", a.merge.parts, "folders of all parts, in any order")->required();
  merge_verb->add_option("-o,--output", a.merge.output, "results, campaign, or calibration.json")->required();
  merge_verb->add_option("--threads", a.merge.threads, "how many threads; 0: one a processor")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  add_force(*merge_verb, a.merge.force);
  add_json(*merge_verb, a.merge.json);
  merge_verb->add_flag("--tables", a.merge.tables, "accuracy: print all tables, as Markdown");
  merge_verb->callback([&] {
    end_in_order();
    code = merge(a.merge);
  });

  auto* report_verb =
      app.add_subcommand("report", "results to a page, Markdown, CSV and LaTeX; nothing is computed again");
  report_verb->add_option("results", a.report.results, "results folders, or a folder of them");
  report_verb->add_option("-o,--output", a.report.output, "folder of the report");
  report_verb->add_option("--time", a.report.time,
                          "the time stamp of the page, any text; without it the time of the day");
  report_verb->add_option(
      "--history", a.report.history,
      "history of nights that `trilat gate` keeps: the last verdict and the errors by night lead");
  report_verb->add_flag("--paper", a.report.paper,
                        "judge the paper's claims by these results, and audit its tables, on the page");
  report_verb->add_flag("--audit", a.report.audit,
                        "print what the paper's own tables imply against what it says; needs no results");
  add_force(*report_verb, a.report.force);
  add_json(*report_verb, a.report.json);
  report_verb->callback([&] { code = report(a.report); });

  auto* reproduce_verb = app.add_subcommand(
      "reproduce",
      "everything: a simulated campaign after the paper, its studies, and the tables beside the paper's");
  reproduce_verb->add_option("-o,--output", a.reproduce.output, "folder of everything that is made")
      ->capture_default_str();
  reproduce_verb
      ->add_option("--scale", a.reproduce.scale,
                   "quick: a look in a minute; paper: its 16 participants for Tables II and III, map and "
                   "calibration in small; full: 200 rigs and the large map too")
      ->check(CLI::IsMember(reproduction_scales()))
      ->capture_default_str();
  reproduce_verb->add_option("--seed", a.reproduce.seed, "of every random number")->capture_default_str();
  reproduce_verb->add_option("--threads", a.reproduce.threads, "how many threads; 0: one a processor")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  add_force(*reproduce_verb, a.reproduce.force);
  add_json(*reproduce_verb, a.reproduce.json);
  reproduce_verb->callback([&] {
    end_in_order();
    code = reproduce(a.reproduce);
  });
}

void add_gate(CLI::App& app, AllArguments& a, int& code) {
  auto* verb = app.add_subcommand("gate", "nightly: is anything worse than the baseline, beyond noise");
  GateArguments& g = a.gate;
  verb->add_option("results", g.results, "a results folder, or a folder that holds several")->required();
  verb->add_option("--baseline", g.baseline, "what to compare with: a folder of the same shape")->required();
  verb->add_option("--history", g.history, "history.jsonl: says since when, and gets one line more");
  verb->add_option("--smallest-effect", g.smallest_percent, "percent; smaller changes are not told")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  verb->add_option("--resamples", g.resamples, "of the bootstrap intervals")
      ->check(CLI::Range(100, 100'000))
      ->capture_default_str();
  verb->add_option("--junit", g.junit, "also write the verdict as JUnit XML to this file");
  verb->add_option("--method", g.method, "list every cell of this method that is not identical");
  auto* accept = verb->add_option(
      "--accept", g.reason, "make these results the baseline, for the reason given, and compare nothing");
  verb->add_option("--threads", g.threads, "how many threads; 0: one a processor")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  add_force(*verb, g.force);
  add_json(*verb, g.json);
  verb->footer(
      "Exit codes: 0 quiet; 1 something is worse; 2 cannot be compared, with the place; 3 not judged: too "
      "few "
      "participants to tell a change from chance.");
  verb->callback([&a, &code, accept] {
    end_in_order();
    a.gate.accepts = accept->count() > 0;
    code = gate(a.gate);
  });
}

int guarded_main(int argc, char** argv) {
  CLI::App app(
      "Offline evaluation of trilateration with several Kinect v2 sensors against OptiTrack.\n"
      "Exit codes: 0 done; 1 done, but items failed; 2 bad input or usage; 70 a bug of this program.",
      "trilat");
  app.set_version_flag("--version", kProgramVersion);
  app.require_subcommand(1);
  app.failure_message(CLI::FailureMessage::help);
  AllArguments arguments;
  int code = kDone;
  add_work(app, arguments, code);
  add_calibrate(app, arguments, code);
  add_measure_tracker(app, arguments, code);
  add_gate(app, arguments, code);
  RecordingArguments recording;
  add_recording_verbs(app, recording, code);
  ExchangeArguments exchange;
  add_exchange_verbs(app, exchange, code);
  add_inspection(app, arguments, code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::CallForAllHelp& help) {
    return app.exit(help);
  } catch (const CLI::CallForVersion& version) {
    return app.exit(version);
  } catch (const CLI::ParseError& error) {
    if (app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-') {
      std::string verbs;
      for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; }))
        verbs += (verbs.empty() ? "" : ", ") + verb->get_name();
      std::fprintf(stderr, "trilat: there is no verb \"%s\"; there are %s\n", argv[1], verbs.c_str());
      return kBadInput;
    }
    const auto given = app.get_subcommands();
    if (given.empty()) {
      std::fprintf(stderr, "trilat: %s; `trilat --help` says what can be asked\n", error.what());
      return kBadInput;
    }
    const CLI::App& verb = *given.front();
    std::string usage = CLI::Formatter().make_usage(&verb, "trilat " + verb.get_name());
    std::erase(usage, '\n');
    std::fprintf(stderr, "trilat: %s: %s. %s; `trilat %s --help` says all\n", verb.get_name().c_str(),
                 error.what(), usage.c_str(), verb.get_name().c_str());
    return kBadInput;
  }
  return code;
}

}  // namespace

}  // namespace trilat

int main(int argc, char** argv) {
  try {
    const int code = trilat::guarded_main(argc, argv);
    if (std::fflush(stdout) != 0) throw trilat::OutputError("stdout", "cannot be written to its end");
    return code;
  } catch (const trilat::InputError& error) {
    std::fprintf(stderr, "trilat: %s\n", error.what());
    return trilat::kBadInput;
  } catch (const trilat::Interrupted&) {
    std::fprintf(stderr, "trilat: interrupted\n");
    return trilat::kItemsFailed;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "trilat: there is not enough memory\n");
    return trilat::kBadInput;
  } catch (const std::filesystem::filesystem_error& error) {
    std::fprintf(stderr, "trilat: %s: %s\n", error.path1().c_str(), error.code().message().c_str());
    return trilat::kBadInput;
  } catch (const std::system_error& error) {  // of fmt, when stdout cannot be written
    std::fprintf(stderr, "trilat: %s\n", error.what());
    return trilat::kBadInput;
  } catch (const std::exception& error) {
    // TBB has no type of its own for a thread that the system does not start
    const bool refused = typeid(error) == typeid(std::runtime_error);
    std::fprintf(stderr,
                 refused ? "trilat: %s\n" : "trilat: this is a bug of the program, please report it: %s\n",
                 error.what());
    return refused ? trilat::kBadInput : trilat::kOurBug;
  }
}
