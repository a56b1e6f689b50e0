// SPDX-License-Identifier: MIT
#include "datasets/results/accepted_baseline.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {

void write_accepted(const std::filesystem::path& folder, const AcceptedBaseline& a) {
  const Json json{{"format", "trilat.accepted"},
                  {"version", 1},
                  {"reason", a.reason},
                  {"time", a.time},
                  {"program", a.program},
                  {"sha256", a.sha256},
                  {"replaces_sha256", a.replaces_sha256},
                  {"replaces_time", a.replaces_time}};
  write_file(folder / "accepted.json", json_text(json, 1) + "\n");
}

std::optional<AcceptedBaseline> read_accepted(const std::filesystem::path& folder) {
  const auto path = folder / "accepted.json";
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  check_format(object, "trilat.accepted", 1);
  AcceptedBaseline a;
  a.reason = object.text("reason");
  a.time = object.text("time");
  a.program = object.text("program");
  a.sha256 = object.text("sha256");
  a.replaces_sha256 = object.text("replaces_sha256");
  a.replaces_time = object.text("replaces_time");
  object.finish();
  return a;
}

}  // namespace trilat
