// SPDX-License-Identifier: MIT
#include "pipeline/cli/verbs.h"

#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <regex>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/words.h"

namespace trilat {
namespace {

std::atomic<int> stop_signals{0};

// The first signal asks for an orderly end; the second takes the default way out.
void on_signal(int number) {
  if (stop_signals.fetch_add(1) > 0) {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
}

using AddVerb = void (*)(CLI::App& app, int& code);
// In the order of --help.
constexpr AddVerb kVerbs[] = {add_demo,      add_init,    add_simulate,  add_run,     add_report,
                              add_reproduce, add_compare, add_calibrate, add_gate,    add_record,
                              add_receive,   add_info,    add_verify,    add_recover, add_draw,
                              add_fuse,      add_schema};

[[noreturn]] void refuse_verb(const CLI::App& app, const std::string& given) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb :
       app.get_subcommands([](const CLI::App* verb) { return !verb->get_group().empty(); }))
    verbs.push_back(verb->get_name());
  throw InputError("there is no verb \"" + given + '"', known_names(given, verbs));
}

// "--campagin is no option of run; did you mean --campaign?", where CLI11 lists what was left over.
std::string unknown_option_text(const CLI::App& verb, const std::string& problem) {
  std::smatch found;
  if (!std::regex_search(problem, found, std::regex(R"(not expected:.* ?(--[\w-]+))"))) return problem;
  const std::string given = found[1];
  std::vector<std::string> known;
  for (const CLI::Option* option : verb.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  const std::string nearest = nearest_name(given, known);
  return fmt::format("{} is not an option of {}{}", given, verb.get_name(),
                     nearest.empty() ? "" : "; did you mean " + nearest + "?");
}

// "--duration-s: \"1s\" is not a number", where CLI11 prints the ends of a range to hundreds of digits.
std::string out_of_range_text(const std::string& problem) {
  std::smatch found;
  if (!std::regex_match(problem, found, std::regex(R"((.*): Value (\S+) not in range (\S+) to (\S+))")))
    return problem;
  char* end = nullptr;
  const std::string value = found[2];
  const double number = std::strtod(value.c_str(), &end);
  if (*end != '\0' || std::isnan(number))
    return fmt::format("{}: \"{}\" is not a number", found[1].str(), value);
  const double low = std::stod(found[3]), high = std::stod(found[4]);
  constexpr double kNoLimit = 1e300;
  return high > kNoLimit
             ? fmt::format("{}: is {}; it must be at least {:g}", found[1].str(), value, low)
             : fmt::format("{}: is {}; it must lie between {:g} and {:g}", found[1].str(), value, low, high);
}

[[noreturn]] void refuse_options(const CLI::App& app, std::string problem) {
  const auto given = app.get_subcommands();
  problem = out_of_range_text(problem);
  if (!given.empty()) problem = unknown_option_text(*given.front(), problem);
  if (given.empty()) throw InputError(problem, "`trilat --help` says what can be asked");
  const std::string name = given.front()->get_name();
  std::string usage = CLI::Formatter().make_usage(given.front(), "trilat " + name);
  std::erase(usage, '\n');
  throw InputError(name, problem + ". " + usage + "; `trilat " + name + " --help` says all");
}

}  // namespace

int run_verb(int argc, char** argv, const std::string& version) {
  CLI::App app(
      "Offline evaluation of trilateration with several Kinect v2 sensors against OptiTrack.\n"
      "Exit codes: 0 done; 1 done, but items failed or something was lost; 2 bad input or usage; 3 (gate) "
      "not judged; 70 a bug of this program; 130 interrupted, the same line goes on.",
      "trilat");
  app.set_version_flag("--version", version);
  app.require_subcommand(1);
  app.failure_message(CLI::FailureMessage::help);
  int code = kDone;
  for (const AddVerb add : kVerbs) add(app, code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // for help or the version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    if (app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-') refuse_verb(app, argv[1]);
    refuse_options(app, error.what());
  }
  return code;
}

bool stop_requested() { return stop_signals.load(std::memory_order_relaxed) > 0; }

void stop_on_interrupt() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGHUP, on_signal);  // a terminal that is closed
}

void add_json(CLI::App& verb, bool& json) {
  verb.add_flag("--json", json, "one JSON document on stdout, and nothing else there");
}

void add_force(CLI::App& verb, bool& force) {
  verb.add_flag("--force", force, "replace whatever has the output's name, whoever wrote it; never an input");
}

void removed_option(CLI::App& verb, const std::string& name, const std::string& instead) {
  const auto refuse = [=](const std::vector<std::string>&) {
    throw InputError(name, "was removed; " + instead);
  };
  verb.add_option_function<std::vector<std::string>>(name, refuse)->expected(0, 1)->group("");
}

void add_threads(CLI::App& verb, int& threads) {
  verb.add_option("--threads", threads, "how many threads; 0: one a processor")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
}

}  // namespace trilat
