// SPDX-License-Identifier: MIT
// `trilat simulate`.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/simulate_take.h"
#include "pipeline/cli/verbs.h"

namespace trilat {

int simulate(const SimulateArguments& arguments) {
  const SimulationSpec spec = read_simulation(arguments.spec, arguments.outside);
  if (std::filesystem::exists(arguments.output) && !std::filesystem::is_directory(arguments.output))
    throw InputError(arguments.output.string(), "is a file; a folder is needed");
  Campaign campaign;
  {
    Progress progress("simulating");
    campaign =
        simulate_campaign(spec, arguments.output, stop_requested, [&](double share) { progress.set(share); });
  }
  if (arguments.json) {
    Json takes = Json::array();
    for (const Take& take : campaign.takes) takes.push_back(take.id);
    Json json{{"campaign", arguments.output.string()}, {"takes", takes}};
    if (spec.wand)
      json["wand"] = {{"session", (arguments.output / "wand" / "session.h5").string()},
                      {"mocap", (arguments.output / "wand" / "mocap.csv").string()},
                      {"mocap_start_host_ns", wand_mocap_start(spec).ns}};
    fmt::print("{}\n", json_text(json, 2));
  } else {
    fmt::print("{} simulated takes: {}\n", campaign.takes.size(),
               (arguments.output / "campaign.json").string());
    if (spec.wand)
      fmt::print("wand recording: {} (mocap starts at host clock {} ns)\n",
                 (arguments.output / "wand" / "session.h5").string(), wand_mocap_start(spec).ns);
  }
  return kDone;
}

}  // namespace trilat
