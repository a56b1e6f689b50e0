// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datasets/session/session_reader.h"

namespace trilat {

enum class Severity { note, warning, error };
std::string_view name_of(Severity severity);

// Something a person should know of a recording: where, what, and what it endangers.
struct Finding {
  Severity severity = Severity::note;
  std::string place;
  std::string text;
  std::string affects = {};  // which studies cannot be trusted, or lose what; empty: none
};

struct VerifyOptions {
  bool read_depth = true;    // decompresses and checks every depth frame
  double gap_periods = 1.5;  // a step between frames longer than this many periods is a gap
};

// Reads everything in the session once, in blocks, and says what is odd. An unreadable row is a finding, not
// an exception. `progress` is called with the share done, in [0, 1].
std::vector<Finding> verify_session(const SessionReader& session, const VerifyOptions& options,
                                    const std::function<void(double)>& progress = {});

// Every sensor has frames of bodies, and none of them holds a body.
bool has_no_bodies(const SessionReader& session);

}  // namespace trilat
