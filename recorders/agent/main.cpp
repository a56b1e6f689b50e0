// SPDX-License-Identifier: MIT
// trilat-agent, on Linux and Windows.
#include <atomic>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>

#include "datasets/base/error.h"
#include "datasets/base/version.h"
#include "datasets/session/host_clock.h"
#include "recorders/agent/run_agent.h"
#include "recorders/kinect_sdk/kinect_source.h"
#include "recorders/test_source.h"
#ifndef _WIN32
#include "recorders/open_source.h"
#endif

namespace trilat {
namespace {

constexpr int kDone = 0, kFramesLost = 1, kBadInput = 2, kInternalError = 70;

std::atomic<int> stop_signals{0};

// The first signal asks for an orderly end; the second takes the default way out.
void on_signal(int number) {
  const bool first = stop_signals.fetch_add(1) == 0;
  std::signal(number, first ? on_signal : SIG_DFL);  // Windows forgets the handler with every signal
  if (!first) std::raise(number);
}

void handle_signals() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
#ifndef _WIN32
  std::signal(SIGHUP, on_signal);
  std::signal(SIGPIPE, SIG_IGN);
#endif
}

void say(const std::string& text) { std::fprintf(stderr, "trilat-agent: %s\n", text.c_str()); }

std::unique_ptr<FrameSource> source_of(const std::string& text) {
#ifdef _WIN32
  if (text == "kinect") return std::make_unique<KinectSource>(kinect::load_kinect_runtime());
#endif
  if (text.starts_with("test:")) {
    double duration_s = 0.0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + 5, end, duration_s);
    if (error == std::errc{} && stop == end && duration_s > 0.0 && duration_s <= 1e6)
      return std::make_unique<TestSource>(duration_s);
    throw InputError("--source", "must be test:SECONDS, is \"" + text + '"');
  }
#ifdef _WIN32
  throw InputError("--source", "must be kinect or test:SECONDS, is \"" + text + '"');
#else
  return open_source(text, "--source", SourceUse::agent);
#endif
}

struct Arguments {
  std::string name, source, recorder, via, remote_program = "trilat", folder = ".";
  double duration_s = 0.0;  // 0: until it is stopped
};

// USER@HOST by SSH, HOST:PORT on this machine, or any program's standard input and output.
Connect connect_of(const Arguments& a) {
  if (!a.via.empty()) return [words = shell_words(a.via)] { return run_program(words); };
  if (a.recorder.empty()) return {};
  if (a.recorder.find('@') == std::string::npos) {
    const SocketAddress address = parse_address(a.recorder);
    if (!is_loopback(address))
      throw InputError("--recorder",
                       '"' + a.recorder + "\" lies beyond this machine: USER@HOST goes there through SSH");
    return [address] { return connect_loopback(address); };
  }
  const std::vector<std::string> words{"ssh",
                                       "-T",
                                       "-o",
                                       "BatchMode=yes",
                                       "-o",
                                       "ServerAliveInterval=2",
                                       "-o",
                                       "ServerAliveCountMax=3",
                                       "-o",
                                       "ConnectTimeout=5",
                                       a.recorder,
                                       "--",
                                       a.remote_program,
                                       "receive"};
  return [words] { return run_program(words); };
}

int end_of(const AgentReport& report) {
  if (!report.was_recorded) {
    say("stopped before the recording began");
    return kDone;
  }
  if (!report.source_problem.empty()) say("the source broke: " + report.source_problem);
  for (const LeftLog& log : report.left)
    say(log.path.string() + " stays here; join it with the others: trilat recover " +
        log.path.filename().string() + " OTHER.trilog... -o session.h5");
  say("done; " + std::to_string(report.frames) + " frames taken, " +
      std::to_string(report.lost_at_source + report.lost_in_queue) + " lost (" +
      std::to_string(report.lost_at_source) + " at the source)");
  return report.whole() ? kDone : kFramesLost;
}

int run(const Arguments& a) {
  AgentOptions options;
  options.name = a.name;
  options.folder = a.folder;
  options.connect = connect_of(a);
  std::int64_t end_ns = 0;  // not before the source is there, which may take seconds to wake up
  options.stop_requested = [&] { return stop_signals > 0 || (end_ns != 0 && host_now_ns() >= end_ns); };
  options.on_status_change = say;
  std::vector<std::unique_ptr<FrameSource>> source;
  source.push_back(source_of(a.source));
  handle_signals();
  if (a.duration_s > 0.0) end_ns = host_now_ns() + std::llround(1e9 * a.duration_s);
  AgentReport report = run_agent(source, options);
  if (!options.connect && report.was_recorded) {  // alone, its log is what was wanted
    for (const LeftLog& log : report.left) say("recorded into " + log.path.string());
    report.left.clear();
  }
  return end_of(report);
}

void add_options(CLI::App& verb, Arguments& a) {
#ifdef _WIN32
  a.source = "kinect";
  const char* sources = "kinect, or test:SECONDS to try the way without a sensor";
#else
  const std::string sources = source_help() + ", or test:SECONDS; at real speed only";
#endif
  verb.add_option("--name", a.name, "of this agent, and of its sensor in the session")->required();
  auto* source = verb.add_option("--source", a.source, sources);
  if (a.source.empty()) source->required();
  verb.add_option("--recorder,--server", a.recorder,
                  "USER@HOST, reached by ssh; HOST:PORT of this machine, as a tunnel's end; without it the "
                  "log stays here");
  verb.add_option("--via", a.via, "a command whose standard input and output lead to `trilat receive`")
      ->excludes("--recorder");
  verb.add_option("--remote-program", a.remote_program, "where trilat lies on the recorder's machine")
      ->capture_default_str();
  verb.add_option("--folder", a.folder, "of this agent's log, until the recorder has all of it")
      ->capture_default_str();
  verb.add_option("--duration-s", a.duration_s, "ends by itself after so many seconds")
      ->check(CLI::Range(0.1, 1e6));
}

void add_removed_options(CLI::App& verb) {
  for (const char* option : {"--keys", "--plain-text", "--buffer-mb"})
    verb.add_option_function<std::vector<std::string>>(
            option,
            [option](const std::vector<std::string>&) {
              throw InputError(option,
                               "was removed; --recorder USER@HOST goes through SSH, and what is not sent "
                               "waits on the disk");
            })
        ->expected(0, 1)
        ->group("");
}

int agent_main(int argc, char** argv) {
  CLI::App app(
      "Records depth and bodies of a sensor on this computer and sends them to a recording elsewhere.\n"
      "Exit codes: 0 done; 1 done, but frames were lost, the source broke or not all arrived;\n"
      "2 bad input or usage, or the recorder refuses; 70 a bug of this program.",
      "trilat-agent");
  app.footer(
      "Examples:\n"
      "  trilat-agent run --name left --recorder user@recorder     # where `trilat record --agents 2` runs\n"
      "  trilat-agent run --name left                              # alone, into left.ID.trilog");
  app.set_version_flag("--version", kProgramVersion);
  app.require_subcommand(1);
  Arguments a;
  CLI::App* const verb = app.add_subcommand("run", "record what a source delivers, and send it");
  add_options(*verb, a);
  add_removed_options(*verb);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    throw InputError("usage", std::string(error.what()) + "; `trilat-agent --help` says what can be asked");
  }
  return run(a);
}

int guarded_main(int argc, char** argv) {
  try {
    return agent_main(argc, argv);
  } catch (const InputError& error) {
    say(error.what());
    return kBadInput;
  } catch (const std::bad_alloc&) {
    say("there is not enough memory");
    return kBadInput;
  } catch (const std::exception& error) {
    say(std::string("this is a bug of the program, please report it: ") + error.what());
    return kInternalError;
  }
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) { return trilat::guarded_main(argc, argv); }
