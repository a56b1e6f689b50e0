// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace trilat {

struct ExportArguments {
  std::string format;
  std::filesystem::path input;  // a session, or for csv a results folder
  std::filesystem::path output;
  std::filesystem::path calibration;
  std::string sensor;
  std::optional<std::uint64_t> body;
  std::string unit = "mm";
  bool force = false;  // may replace what others wrote
  bool json = false;
};
int export_recording(const ExportArguments& arguments);

struct FuseArguments {
  std::filesystem::path session, calibration, output;
  std::string method = "range_bearing";
  std::string sensor;  // of single
  double rate_hz = 30.0;
  bool force = false;  // may replace what others wrote
  bool json = false;
};
int fuse(const FuseArguments& arguments);

struct ExchangeArguments {
  FuseArguments fuse;
  ExportArguments output;
};

// The verbs that speak other people's formats. `arguments` live as long as `app` is used; `code` gets the
// verb's exit code.
void add_exchange_verbs(CLI::App& app, ExchangeArguments& arguments, int& code);

}  // namespace trilat
