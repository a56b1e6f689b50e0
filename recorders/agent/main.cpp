// SPDX-License-Identifier: MIT
#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/version.h"
#include "recorders/network/agent_connect.h"
#include "recorders/network/agent_link.h"
#include "recorders/network/steady_time.h"
#include "recorders/network/tls_keys.h"
#include "recorders/open_source.h"

namespace trilat {
namespace {

constexpr int kDone = 0, kFramesLost = 1, kBadInput = 2, kOurBug = 70;
constexpr std::chrono::milliseconds kLookPeriod{100};
constexpr int kLooksAStatus = 50;

std::atomic<int> stop_signals{0};

// The first signal asks for an orderly end; the second takes the default way out.
void on_signal(int number) {
  if (stop_signals.fetch_add(1) == 0) return;
  std::signal(number, SIG_DFL);
  std::raise(number);
}

struct RunArguments {
  std::string server, keys, source, name;
  std::size_t buffer_mb = AgentOptions{}.ring_bytes >> 20;
  bool plain_text = false;
};

struct KeysArguments {
  std::string folder;
  std::vector<std::string> agents;
};

std::string text_of(const AgentStatus& status) {
  return fmt::format("trilat-agent: {}; {} frames taken, {} lost, {:.1f} MB waiting",
                     !status.connected   ? "not connected"
                     : !status.recording ? "waiting for the recording"
                                         : "recording",
                     status.frames_taken, status.frames_lost,
                     static_cast<double>(status.buffered_bytes) * 1e-6);
}

// Shows how it goes and passes a signal on, until the link has ended.
class Watch {
 public:
  explicit Watch(AgentLink& link) : thread_([this, &link] { run(link); }) {}
  ~Watch() {
    ended_ = true;
    thread_.join();
  }

 private:
  void run(AgentLink& link) {
    std::string shown;
    for (int look = 1; !ended_; ++look) {
      if (stop_signals > 0) link.stop();
      if (look % kLooksAStatus == 0)
        if (const std::string text = text_of(link.status()); text != shown) {
          std::fprintf(stderr, "%s\n", text.c_str());
          shown = text;
        }
      std::this_thread::sleep_for(kLookPeriod);
    }
  }
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

int end_of(const AgentReport& report) {
  if (!report.source_problem.empty())
    std::fprintf(stderr, "trilat-agent: the source broke: %s\n", report.source_problem.c_str());
  const auto taken = static_cast<unsigned long long>(report.status.frames_taken);
  const auto lost = static_cast<unsigned long long>(report.status.frames_lost);
  if (report.end == AgentEnd::unacknowledged && taken > 0) {
    std::fprintf(stderr,
                 "trilat-agent: the recording machine does not answer; not all of %llu frames arrived\n",
                 taken);
    return kFramesLost;
  }
  if (report.status.recordings_abandoned > 0)
    std::fprintf(stderr,
                 "trilat-agent: a recording that it took part in was broken off on the recording machine\n");
  std::fprintf(stderr, "trilat-agent: %s; %llu frames taken, %llu lost\n",
               report.end == AgentEnd::ended_by_server ? "the recording is over"
               : report.end == AgentEnd::abandoned     ? "nothing left to send"
                                                       : "done",
               taken, lost);
  return lost > 0 || report.status.recordings_abandoned > 0 || !report.source_problem.empty() ? kFramesLost
                                                                                              : kDone;
}

int run(const RunArguments& arguments) {
  AgentOptions options;
  options.name = arguments.name;
  options.incarnation =
      static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
  options.ring_bytes = arguments.buffer_mb << 20;
  options.on_news = [](const std::string& news) { std::fprintf(stderr, "trilat-agent: %s\n", news.c_str()); };
  std::shared_ptr<const TlsIdentity> identity;
  if (!arguments.keys.empty()) {
    identity = std::make_shared<TlsIdentity>(arguments.keys);
    if (options.name.empty()) options.name = identity->name();
    if (options.name != identity->name())
      throw InputError("--name", "must be \"" + identity->name() + "\", as the key says, or be left out");
  }
  if (options.name.empty()) throw InputError("--name", "is needed where no keys are given");
  const ConnectLink connect =
      connect_to_server(parse_address(arguments.server), identity, arguments.plain_text);
  const auto source = open_source(arguments.source, "--source", SourceUse::agent);
  AgentLink link(*source, options, connect);
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  const Watch watch(link);
  return end_of(link.run());
}

int make_keys(const KeysArguments& arguments) {
  const auto made = make_tls_keys(arguments.folder, arguments.agents);
  for (const auto& path : made) std::printf("%s\n", path.c_str());
  if (made.empty()) std::fprintf(stderr, "trilat-agent: nothing was missing\n");
  return kDone;
}

void add_run(CLI::App& app, RunArguments& arguments) {
  auto* verb = app.add_subcommand("run", "send what a source delivers to the recording machine");
  verb->add_option("--server", arguments.server, "HOST:PORT of `trilat record --listen`")->required();
  verb->add_option("--keys", arguments.keys, "this agent's key file, as made by `trilat-agent keys`");
  verb->add_option("--source", arguments.source, source_help() + "; at real speed only")->required();
  verb->add_option("--name", arguments.name, "of this agent; with keys it is the key's");
  verb->add_option("--buffer-mb", arguments.buffer_mb,
                   "how much to keep while the recording machine does not take it; then the oldest frames go")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
  verb->add_flag("--plain-text", arguments.plain_text,
                 "without keys: let everybody on the way read and write");
}

void add_keys(CLI::App& app, KeysArguments& arguments) {
  auto* verb = app.add_subcommand("keys", "make what is missing of a set of keys; nothing is overwritten");
  verb->add_option("folder", arguments.folder, "of ca.pem, server.pem and NAME.pem")->required();
  verb->add_option("names", arguments.agents, "of agents that need a key");
}

int guarded_main(int argc, char** argv) {
  CLI::App app(
      "Sends depth and bodies of a sensor on this computer to a recording elsewhere.\n"
      "Exit codes: 0 done; 1 done, but frames were lost, the source broke or a recording was broken off; 2 "
      "bad input or usage; 70 a bug "
      "of this program.",
      "trilat-agent");
  app.footer(
      "Example: on the recording machine\n"
      "  trilat-agent keys keys k1 k2\n"
      "then copy keys/k1.pem to the first sensor's computer and there\n"
      "  trilat-agent run --server 192.168.1.10:7345 --keys k1.pem --source synthetic:1");
  app.set_version_flag("--version", kProgramVersion);
  app.require_subcommand(1);
  RunArguments run_arguments;
  KeysArguments keys_arguments;
  add_run(app, run_arguments);
  add_keys(app, keys_arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "trilat-agent: %s; `trilat-agent --help` says what can be asked\n", error.what());
    return kBadInput;
  }
  return app.got_subcommand("run") ? run(run_arguments) : make_keys(keys_arguments);
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  try {
    return trilat::guarded_main(argc, argv);
  } catch (const trilat::InputError& error) {
    std::fprintf(stderr, "trilat-agent: %s\n", error.what());
    return trilat::kBadInput;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "trilat-agent: there is not enough memory\n");
    return trilat::kBadInput;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "trilat-agent: this is a bug of the program, please report it: %s\n", error.what());
    return trilat::kOurBug;
  }
}
