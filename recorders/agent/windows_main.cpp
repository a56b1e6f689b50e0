// SPDX-License-Identifier: MIT
#include <charconv>
#include <string>

#include <CLI/CLI.hpp>

#include "datasets/base/error.h"
#include "datasets/base/version.h"
#include "recorders/agent/run_agent.h"
#include "recorders/kinect_sdk/kinect_source.h"
#include "recorders/network/plain_connect.h"
#include "recorders/test_source.h"

namespace trilat {
namespace {

constexpr const char* kTunnelHelp =
    "Frames travel through an SSH tunnel, which Windows can make by itself. In another window, and first:\n"
    "  ssh -N -L 7345:127.0.0.1:7345 USER@RECORDING_MACHINE\n"
    "then\n"
    "  trilat-agent run --name k1";

struct RunArguments {
  std::string server = "127.0.0.1:7345", source = "kinect", name;
  std::size_t buffer_mb = AgentOptions{}.ring_bytes >> 20;
};

std::unique_ptr<FrameSource> open_source(const std::string& text) {
  if (text == "kinect") return std::make_unique<KinectSource>(kinect::load_kinect_runtime());
  if (text.starts_with("test:")) {
    double duration_s = 0.0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + 5, end, duration_s);
    if (error == std::errc{} && stop == end && duration_s > 0.0 && duration_s <= 1e6)
      return std::make_unique<TestSource>(duration_s);
  }
  throw InputError("--source", "must be kinect or test:SECONDS, is \"" + text + '"');
}

int agent_main(int argc, char** argv) {
  CLI::App app(
      "Sends depth and bodies of this computer's Kinect v2 to a recording elsewhere.\n"
      "Exit codes: 0 done; 1 done, but frames were lost; 2 bad input or usage; 70 a bug of this program.",
      "trilat-agent");
  app.footer(kTunnelHelp);
  app.set_version_flag("--version", kProgramVersion);
  app.require_subcommand(1);
  RunArguments arguments;
  auto* verb = app.add_subcommand("run", "send what a source delivers to the recording machine");
  verb->add_option("--server", arguments.server, "this computer's end of the tunnel")->capture_default_str();
  verb->add_option("--source", arguments.source, "kinect, or test:SECONDS to try the way without a sensor")
      ->capture_default_str();
  verb->add_option("--name", arguments.name, "of this agent")->required();
  add_buffer_option(*verb, arguments.buffer_mb);
  if (const auto end = parse_agent_arguments(app, argc, argv)) return *end;

  AgentOptions options;
  options.name = arguments.name;
  options.ring_bytes = arguments.buffer_mb << 20;
  const ConnectLink connect = connect_in_plain_text(parse_address(arguments.server));
  const auto source = open_source(arguments.source);
  return run_agent(*source, options, connect);
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) { return trilat::guarded_agent_main(trilat::agent_main, argc, argv); }
