// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "datasets/base/files.h"

namespace trilat {

// Exit codes of every verb. Bad input and bugs leave by exception: 2 and 70.
enum ExitCode {
  kDone = 0,
  kItemsFailed = 1,
  kBadInput = 2,
  kNotJudged = 3,
  kInternalError = 70,
  kInterrupted = 130  // by Ctrl-C or SIGTERM: the same line goes on
};

// Runs the verb on the command line and gives its exit code. InputError for a verb that there is not and
// for options that it does not have; all that verbs throw. `version`: what --version says.
int run_verb(int argc, char** argv, const std::string& version);

// True once the process has been asked to end (Ctrl-C, SIGTERM). Long work asks between items.
bool stop_requested();
// From now on Ctrl-C asks; without, the program just ends.
void stop_on_interrupt();

// Effect of Ctrl-C on a verb: one that leaves something behind ends in order.
enum class OnInterrupt { in_order, at_once };

// A verb, to which options are added, and the arguments that they fill in.
template <class Arguments>
struct Verb {
  CLI::App& verb;
  Arguments& arguments;
};

// A verb is one file: its arguments, its work and a function that adds it here, which main.cpp lists. `code`
// gets what `work` returns.
template <class Arguments>
Verb<Arguments> add_verb(CLI::App& app, int& code, const std::string& name, const std::string& what,
                         int (*work)(const Arguments&), OnInterrupt ends = OnInterrupt::in_order) {
  CLI::App* verb = app.add_subcommand(name, what);
  const auto arguments = std::make_shared<Arguments>();
  verb->callback([=, &code] {
    if (ends == OnInterrupt::in_order) stop_on_interrupt();
    code = work(*arguments);
  });
  return {*verb, *arguments};
}

// Options that several verbs have.
void add_json(CLI::App& verb, bool& json);
void add_force(CLI::App& verb, bool& force);
void add_threads(CLI::App& verb, int& threads);
// An option of earlier versions, which is refused with what to use instead and is not in --help.
void removed_option(CLI::App& verb, const std::string& name, const std::string& instead);

void add_calibrate(CLI::App& app, int& code);
void add_compare(CLI::App& app, int& code);
void add_demo(CLI::App& app, int& code);
void add_draw(CLI::App& app, int& code);
void add_fuse(CLI::App& app, int& code);
void add_gate(CLI::App& app, int& code);
void add_info(CLI::App& app, int& code);
void add_init(CLI::App& app, int& code);
void add_receive(CLI::App& app, int& code);
void add_record(CLI::App& app, int& code);
void add_recover(CLI::App& app, int& code);
void add_report(CLI::App& app, int& code);
void add_reproduce(CLI::App& app, int& code);
void add_run(CLI::App& app, int& code);
void add_schema(CLI::App& app, int& code);
void add_simulate(CLI::App& app, int& code);
void add_verify(CLI::App& app, int& code);

// `trilat info` of motion capture: format, rate, unit, every asset with samples, gaps, frozen stretches.
int info_of_mocap(const std::filesystem::path& file, bool json);

}  // namespace trilat
