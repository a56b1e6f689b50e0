// SPDX-License-Identifier: MIT
// `trilat simulate`.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/merge_kinds.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/reused_results.h"
#include "pipeline/cli/simulate_part.h"
#include "pipeline/cli/simulate_take.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

std::vector<std::filesystem::path> files_of(const SimulateArguments& arguments, const SimulationSpec& spec) {
  if (!spec.recorded) return {arguments.spec};
  return {arguments.spec, spec.recorded->mocap, spec.recorded->mapping};
}

int simulate_shard(const SimulateArguments& arguments, const Shard& shard) {
  WatchedFiles inputs({arguments.spec});
  const SimulationSpec spec = read_simulation(arguments.spec, arguments.outside);
  check_output({arguments.output, OutputKind::campaign_part, files_of(arguments, spec), arguments.force,
                kCampaignPart});
  std::string sha256 = hash_of_file(arguments.spec);
  if (spec.recorded)
    for (const std::filesystem::path& file : {spec.recorded->mocap, spec.recorded->mapping}) {
      inputs.add(file);
      sha256 += hash_of_file(file);
    }
  ItemTally tally;
  {
    Progress progress("simulating");
    tally =
        simulate_part(spec, hash_of_text(sha256), shard, arguments.output,
                      {stop_requested, [&](double share) { progress.set(share); }, inputs, arguments.force});
  }
  tell_reuse("recordings", tally);
  print_part(arguments.output, shard, tally, arguments.json);
  return kDone;
}

}  // namespace

int simulate(const SimulateArguments& arguments) {
  if (!arguments.shard.empty()) return simulate_shard(arguments, parse_shard(arguments.shard, "--shard"));
  const SimulationSpec spec = read_simulation(arguments.spec, arguments.outside);
  check_output({arguments.output, OutputKind::campaign, files_of(arguments, spec), arguments.force});
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

int merge_simulated_campaign(const MergeArguments& arguments, const std::vector<FoundPart>& parts) {
  merge_campaign(parts, arguments.output);
  const Campaign campaign = read_campaign(arguments.output);
  if (arguments.json)
    fmt::print("{}\n",
               json_text({{"campaign", arguments.output.string()}, {"takes", campaign.takes.size()}}, 2));
  else
    fmt::print("{} simulated takes: {}\n", campaign.takes.size(),
               (arguments.output / "campaign.json").string());
  return kDone;
}

}  // namespace trilat
