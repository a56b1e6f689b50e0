// SPDX-License-Identifier: MIT
// `trilat run` for a study of kind recording.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "pipeline/cli/part_progress.h"
#include "pipeline/cli/time_capture.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/recording_study/execute_recording.h"
#include "reports/render.h"
#include "reports/table4.h"

namespace trilat {
namespace {

int print_plan(const RecordingSpec& spec, bool json) {
  const std::uint64_t samples = spec.runs * spec.sensors * spec.frames;
  if (json) {
    fmt::print("{}\n", json_text({{"study", resolved_json(spec)}, {"samples_of_each_network", samples}}, 2));
    return kDone;
  }
  fmt::print(
      "study {} (simulated): {} networks, of each {} runs x {} sensors x {} frames; {} methods timed on {} "
      "frames\n",
      spec.name, spec.networks.size(), spec.runs, spec.sensors, spec.frames, spec.methods.size(),
      spec.frames);
  return kDone;
}

}  // namespace

int run_recording_study(const RunArguments& arguments, const Json& study) {
  if (!arguments.campaign.empty() || !arguments.calibration.empty())
    throw InputError(arguments.campaign.empty() ? "--calibration" : "--campaign",
                     "is of no use: a recording study simulates its own recordings");
  if (arguments.cross_check) throw InputError("--cross-check", "is for studies of kind accuracy");
  const RecordingSpec spec = parse_recording_spec(study, arguments.study.string());
  if (arguments.dry_run) return print_plan(spec, arguments.json);
  if (arguments.output.empty()) throw InputError("--output", "is missing: where should the results go?");
  RecordingOutcome outcome;
  {
    PartProgress progress;
    outcome = execute_recording(spec, arguments.output,
                                {arguments.threads, stop_requested,
                                 [&](const std::string& part, double share) { progress.set(part, share); },
                                 [&](const std::filesystem::path& folder, const RecordingHooks& hooks) {
                                   return time_capture(spec, folder, hooks);
                                 }});
  }
  const bool interrupted = outcome.summary.interrupted;
  const std::filesystem::path folder =
      interrupted ? arguments.output.string() + ".partial" : arguments.output.string();
  if (arguments.json) {
    fmt::print(
        "{}\n",
        json_text({{"results", folder.string()}, {"simulated", true}, {"interrupted", interrupted}}, 2));
  } else {
    for (const Table& table : table4(outcome.summary, outcome.timings))
      fmt::print("{}\n", markdown_of(table));
    fmt::print("results: {}\n", folder.string());
  }
  if (!interrupted) return kDone;
  fmt::print(stderr, "trilat: interrupted; what was finished has been kept in {}\n", folder.string());
  return kItemsFailed;
}

}  // namespace trilat
