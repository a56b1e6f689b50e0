// SPDX-License-Identifier: MIT
#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "datasets/base/error.h"
#include "datasets/base/version.h"
#include "recorders/agent/run_agent.h"
#include "recorders/network/agent_connect.h"
#include "recorders/network/link/tls_keys.h"
#include "recorders/open_source.h"

namespace trilat {
namespace {

struct RunArguments {
  std::string server, key, source, name;
  std::size_t buffer_mb = AgentOptions{}.ring_bytes >> 20;
  bool plain_text = false;
};

struct KeysArguments {
  std::string folder;
  std::vector<std::string> agents;
};

int run(const RunArguments& arguments) {
  AgentOptions options;
  options.name = arguments.name;
  options.ring_bytes = arguments.buffer_mb << 20;
  TlsKeys keys;
  if (!arguments.key.empty()) {
    keys = read_tls_keys(arguments.key);
    if (keys.size() != 1)
      throw InputError(arguments.key,
                       "holds the keys of several agents; here NAME.key of this one is needed");
    const std::string& name = keys.begin()->first;
    if (options.name.empty()) options.name = name;
    if (options.name != name)
      throw InputError("--name", "must be \"" + name + "\", as the key says, or be left out");
  }
  if (options.name.empty()) throw InputError("--name", "is needed where no key is given");
  const ConnectLink connect = connect_to_server(parse_address(arguments.server), keys, arguments.plain_text);
  const auto source = open_source(arguments.source, "--source", SourceUse::agent);
  return run_agent(*source, options, connect);
}

int make_keys(const KeysArguments& arguments) {
  const auto made = make_tls_keys(arguments.folder, arguments.agents);
  for (const auto& path : made) std::printf("%s\n", path.c_str());
  return kDone;
}

void add_run(CLI::App& app, RunArguments& arguments) {
  auto* verb = app.add_subcommand("run", "send what a source delivers to the recording machine");
  verb->add_option("--server", arguments.server, "HOST:PORT of `trilat record --listen`")->required();
  verb->add_option("--keys", arguments.key, "this agent's NAME.key, as made by `trilat-agent keys`");
  verb->add_option("--source", arguments.source, source_help() + "; at real speed only")->required();
  verb->add_option("--name", arguments.name, "of this agent; with a key it is the key's");
  add_buffer_option(*verb, arguments.buffer_mb);
  verb->add_flag("--plain-text", arguments.plain_text,
                 "without a key: let everybody on the way read and write");
}

void add_keys(CLI::App& app, KeysArguments& arguments) {
  auto* verb = app.add_subcommand("keys", "make keys of agents; nothing is overwritten");
  verb->add_option("folder", arguments.folder, "of recorder.keys and NAME.key")->required();
  verb->add_option("names", arguments.agents, "of agents that need a key")->required();
}

int agent_main(int argc, char** argv) {
  CLI::App app(
      "Sends depth and bodies of a sensor on this computer to a recording elsewhere.\n"
      "Exit codes: 0 done; 1 done, but frames were lost, the source broke or a recording was broken off;\n"
      "2 bad input or usage; 70 a bug of this program.",
      "trilat-agent");
  app.footer(
      "Example: on the recording machine\n"
      "  trilat-agent keys keys k1 k2\n"
      "then copy keys/k1.key to the first sensor's computer and there\n"
      "  trilat-agent run --server 192.168.1.10:7345 --keys k1.key --source synthetic:1");
  app.set_version_flag("--version", kProgramVersion);
  app.require_subcommand(1);
  RunArguments run_arguments;
  KeysArguments keys_arguments;
  add_run(app, run_arguments);
  add_keys(app, keys_arguments);
  if (const auto end = parse_agent_arguments(app, argc, argv)) return *end;
  return app.got_subcommand("run") ? run(run_arguments) : make_keys(keys_arguments);
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) { return trilat::guarded_agent_main(trilat::agent_main, argc, argv); }
