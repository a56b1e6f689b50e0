// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

#include "pipeline/cli/verbs.h"

namespace trilat {

struct RecordingArguments {
  RecordArguments record;
  InfoArguments info;
  VerifyArguments verify;
  RecoverArguments recover;
};

// The verbs about one session: record, info, verify, recover. `arguments` live as long as `app` is used;
// `code` gets the verb's exit code.
void add_recording_verbs(CLI::App& app, RecordingArguments& arguments, int& code);

// The flag that every verb has.
void add_json(CLI::App& verb, bool& json);
// And every verb that writes something.
void add_force(CLI::App& verb, bool& force);
// An option of earlier versions; InputError with what to do instead.
void add_gone(CLI::App& verb, const std::string& option, const std::string& instead);

}  // namespace trilat
