// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <optional>

#include <CLI/CLI.hpp>

#include "recorders/network/agent_link.h"

namespace trilat {

// Exit codes of an agent.
inline constexpr int kDone = 0, kFramesLost = 1, kBadInput = 2, kOurBug = 70;

// Sends until there is no more to send or Ctrl-C, tells a person on standard error how it goes, and returns
// the exit code. The run of the agent and where news go are filled in here. Once in a process.
int run_agent(FrameSource& source, AgentOptions options, const ConnectLink& connect);

// Runs `body` and turns what it throws into a message and an exit code.
int guarded_agent_main(int (*body)(int argc, char** argv), int argc, char** argv);

// The exit code where there is nothing more to do than to help or to complain.
inline std::optional<int> parse_agent_arguments(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "trilat-agent: %s; `trilat-agent --help` says what can be asked\n", error.what());
    return kBadInput;
  }
  return std::nullopt;
}

inline void add_buffer_option(CLI::App& verb, std::size_t& buffer_mb) {
  verb.add_option("--buffer-mb", buffer_mb,
                  "how much to keep while the recording machine does not take it; then the oldest frames go")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
}

}  // namespace trilat
