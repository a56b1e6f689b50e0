// SPDX-License-Identifier: MIT
#include "pipeline/cli/kinds.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/results/results_file.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/cli/print_stored.h"
#include "pipeline/clocks/clocks_study.h"
#include "pipeline/sweep/sweep_study.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

// An opened study that is planned at once.
OpenedStudy opened(Study study, const Json& plan, const std::string& text) {
  return {.plan = [study = std::move(study)](const Watch&) { return study; },
          .print_plan =
              [plan, text](const Shard&, bool json, const Watch&) {
                fmt::print("{}\n", json ? json_text(plan, 2) : text);
                return int{kDone};
              }};
}

OpenedStudy open_calibration(const RunArguments& arguments, const Json& study) {
  const CalibrationSpec spec = parse_calibration_spec(study, arguments.study.string());
  const std::uint64_t images = 2 * spec.units * (spec.samples + spec.near_samples) * spec.frames +
                               spec.distortion_units * spec.distortion_frames +
                               spec.runs * spec.positions * spec.position_frames * spec.rig.heights_m.size();
  return opened(
      calibration_study(spec), {{"study", resolved_json(spec)}, {"images", images}},
      fmt::format("study {} (simulated): {} samples of each of {} units in two scenes, a wall in {} frames "
                  "of {} units, {} rigs with {} wand positions; {} depth images to render",
                  spec.name, spec.samples + spec.near_samples, spec.units, spec.distortion_frames,
                  spec.distortion_units, spec.runs, spec.positions, images));
}

// A campaign, or a folder of recordings without campaign.json, or one session.
Campaign recordings_of(const fs::path& of_study, const RunArguments& arguments) {
  const fs::path folder = arguments.campaign.empty() ? of_study : arguments.campaign;
  const bool is_session = folder.extension() == ".h5" && fs::is_regular_file(folder);
  if (!is_session &&
      (!fs::is_directory(folder) || fs::exists(folder / "campaign.json") || fs::exists(folder / "items")))
    return campaign_of(of_study, arguments);
  Campaign campaign;
  campaign.name = fs::absolute(folder).lexically_normal().stem().string();
  campaign.folder = is_session ? folder.parent_path() : folder;
  for (const fs::path& file : is_session ? std::vector{folder} : files_below(folder, {".h5"})) {
    Take& take = campaign.takes.emplace_back();
    take.id = is_session ? file.filename().string() : file.lexically_relative(folder).generic_string();
    take.session = file;
  }
  if (campaign.takes.empty())
    throw InputError(folder.string(),
                     "holds no campaign.json and no recording (session.h5); `trilat record` makes one");
  return campaign;
}

OpenedStudy open_clocks(const RunArguments& arguments, const Json& study) {
  const ClocksSpec spec = parse_clocks_spec(study, arguments.study.string(), arguments.study.parent_path());
  const Campaign campaign = recordings_of(spec.campaign, arguments);
  const auto hashes = std::make_shared<HashCache>();
  hashes->load(arguments.output);
  std::uint64_t sessions = campaign.wand.has_value();
  for (const Take& take : campaign.takes) sessions += !take.session.empty();
  OpenedStudy opened_study = opened(
      clocks_study(spec, campaign, hashes),
      {{"study", resolved_json(spec)}, {"campaign", campaign.name}, {"sessions", sessions}},
      fmt::format("study {} on campaign {}: clocks of {} sessions", spec.name, campaign.name, sessions));
  opened_study.inputs = inputs_of(campaign);
  opened_study.campaign = campaign;
  return opened_study;
}

int print_tables(const std::filesystem::path& results, Json document, const Shown& shown) {
  if (shown.json) {
    document.update(
        Json{{"results", results.string()}, {"simulated", read_results_json(results).at("simulated")}});
    fmt::print("{}\n", json_text(document, 2));
    return kDone;
  }
  print_stored(results, true);
  fmt::print("results: {}\n", results.string());
  return kDone;
}

}  // namespace

std::vector<fs::path> files_below(const fs::path& folder, const std::set<std::string>& extensions) {
  std::vector<fs::path> files;
  auto entry = fs::recursive_directory_iterator(folder);
  for (; entry != fs::recursive_directory_iterator(); ++entry) {
    if (entry->is_directory() && fs::exists(entry->path() / "manifest.json"))
      entry.disable_recursion_pending();
    if (entry->is_regular_file() && extensions.contains(entry->path().extension().string()))
      files.push_back(entry->path());
  }
  std::ranges::sort(files);
  return files;
}

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> kinds{
      {StudyKind::accuracy, "takes", "", open_accuracy, print_accuracy, accuracy_schema},
      {StudyKind::threshold_sweep, "items",
       "a threshold sweep makes its own trials and places its own sensors", open_sweep, print_sweep,
       sweep_schema},
      {StudyKind::calibration, "items", "a calibration study renders its own images", open_calibration,
       print_tables, calibration_study_schema},
      {StudyKind::clocks, "items", "", open_clocks, print_tables, clocks_schema}};
  return kinds;
}

const Kind* find_kind(const std::string& name) {
  const auto found = std::find_if(kinds().begin(), kinds().end(),
                                  [&](const Kind& kind) { return name_of(kind.kind) == name; });
  return found == kinds().end() ? nullptr : &*found;
}

}  // namespace trilat
