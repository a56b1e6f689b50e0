// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace trilat {

// Why a baseline is what it is.
struct AcceptedBaseline {
  std::string reason;
  std::string time;             // UTC, ISO 8601
  std::string program;          // that accepted it
  std::string sha256;           // of its results: names and contents of their files
  std::string replaces_sha256;  // of the baseline before; empty: there was none
  std::string replaces_time;    // when that one had been accepted; empty when not known
};

// accepted.json (trilat.accepted, version 1) in the baseline's folder.
void write_accepted(const std::filesystem::path& folder, const AcceptedBaseline& accepted);
// Nothing when the folder has none; InputError when it is not one.
std::optional<AcceptedBaseline> read_accepted(const std::filesystem::path& folder);

}  // namespace trilat
