// SPDX-License-Identifier: MIT
#pragma once

#include "recorders/network/agent_link.h"

namespace trilat {

// Exit codes of an agent.
inline constexpr int kDone = 0, kFramesLost = 1, kBadInput = 2, kOurBug = 70;

// Sends until there is no more to send or Ctrl-C, tells a person on standard error how it goes, and returns
// the exit code. The run of the agent and where news go are filled in here. Once in a process.
int run_agent(FrameSource& source, AgentOptions options, const ConnectLink& connect);

// Runs `body` and turns what it throws into a message and an exit code.
int guarded_agent_main(int (*body)(int argc, char** argv), int argc, char** argv);

}  // namespace trilat
