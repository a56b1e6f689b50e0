// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace trilat {

struct ImportArguments {
  std::string format;
  std::vector<std::filesystem::path> files;
  std::filesystem::path output;
  std::optional<double> rate_hz;
  std::optional<double> depth_unit_mm;
  std::filesystem::path timestamps;
  bool time_from_name = false;
  std::string compression = "blosc";
  bool json = false;
};
// kItemsFailed when rows were left out.
int import_session(const ImportArguments& arguments);

}  // namespace trilat
