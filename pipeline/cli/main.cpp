// SPDX-License-Identifier: MIT
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <typeinfo>

#include "datasets/base/error.h"
#include "datasets/base/known_names.h"
#include "datasets/base/version.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

using AddVerb = void (*)(CLI::App& app, int& code);
// In the order of --help.
constexpr AddVerb kVerbs[] = {add_demo,      add_init,      add_simulate, add_run,    add_report,
                              add_reproduce, add_calibrate, add_gate,     add_record, add_info,
                              add_verify,    add_recover,   add_fuse,     add_schema};

int guarded_main(int argc, char** argv) {
  CLI::App app(
      "Offline evaluation of trilateration with several Kinect v2 sensors against OptiTrack.\n"
      "Exit codes: 0 done; 1 done, but items failed or something was lost; 2 bad input or usage; 3 (gate) "
      "not "
      "judged; 70 a bug of this program; 130 interrupted, the same line goes on.",
      "trilat");
  app.set_version_flag("--version", std::string(kProgramVersion) + "\n" + TRILAT_BUILD);
  app.require_subcommand(1);
  app.failure_message(CLI::FailureMessage::help);
  int code = kDone;
  for (const AddVerb add : kVerbs) add(app, code);
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
      std::vector<std::string> verbs;
      for (const CLI::App* verb :
           app.get_subcommands([](const CLI::App* verb) { return !verb->get_group().empty(); }))
        verbs.push_back(verb->get_name());
      std::fprintf(stderr, "trilat: there is no verb \"%s\"; %s\n", argv[1],
                   known_names(argv[1], verbs).c_str());
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
    return trilat::kInterrupted;
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
