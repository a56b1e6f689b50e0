// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <optional>

#include <CLI/CLI.hpp>

#include "recorders/agent/run_agent.h"

namespace trilat {

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
