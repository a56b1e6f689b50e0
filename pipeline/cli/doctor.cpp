// SPDX-License-Identifier: MIT
// `trilat doctor`.
#include <cstdlib>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"
#include "pipeline/accuracy/memory_budget.h"
#include "pipeline/cli/verbs.h"
#include "reports/write_report.h"

namespace trilat {
namespace {

struct DoctorArguments {
  bool json = false;
};

// Something outside the program that a part of it needs.
struct Need {
  std::string name, what_for, how;
  bool found = false;
};

bool runs(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

std::vector<Need> needs() {
  return {{"gnuplot", "figures of the report", "apt-get install gnuplot-nox", runs("command -v gnuplot")},
          {"three.js", "the replay on the page", "apt-get install libjs-three",
           std::filesystem::exists(ReportOptions{}.three_js)},
          {"h5py and numpy", "the Python module and the converters",
           "apt-get install python3-h5py python3-numpy", runs("python3 -c 'import h5py, numpy'")},
          {"hdf5plugin", "recorded depth in Python", "apt-get install python3-hdf5plugin",
           runs("python3 -c 'import hdf5plugin'")},
          {"flock", "scripts/nightly", "apt-get install util-linux", runs("command -v flock")}};
}

int doctor(const DoctorArguments& arguments) {
  constexpr double kBytesPerGb = 1e9, kEnough_gb = 2.0;
  const std::vector<Need> all = needs();
  std::error_code ignored;
  const double free_gb =
      static_cast<double>(std::filesystem::space(std::filesystem::current_path(), ignored).available) /
      kBytesPerGb;
  const double memory_gb = 2.0 * static_cast<double>(half_of_memory_bytes()) / kBytesPerGb;
  Json document{{"free_gb", free_gb},
                {"memory_gb", memory_gb},
                {"processors", std::thread::hardware_concurrency()},
                {"needs", Json::array()}};
  for (const Need& need : all)
    document["needs"].push_back(
        {{"name", need.name}, {"for", need.what_for}, {"found", need.found}, {"how", need.how}});
  if (arguments.json) {
    fmt::print("{}\n", json_text(document, 2));
    return kDone;
  }
  for (const Need& need : all)
    fmt::print("{:<8} {}, for {}{}\n", need.found ? "found" : "missing", need.name, need.what_for,
               need.found ? "" : "; " + need.how);
  fmt::print("{:<8} {:.0f} GB free here{}\n", free_gb < kEnough_gb ? "little" : "found", free_gb,
             free_gb < kEnough_gb ? "; a reproduction takes 1, recordings with depth much more" : "");
  fmt::print("{:<8} {:.0f} GB of memory, {} processors\n", "found", memory_gb,
             std::thread::hardware_concurrency());
  return kDone;
}

}  // namespace

void add_doctor(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<DoctorArguments>(
      app, code, "doctor", "what of the programs and libraries that some verbs need is missing here", doctor,
      Ends::at_once);
  add_json(verb, a.json);
}

}  // namespace trilat
