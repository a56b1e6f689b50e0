// SPDX-License-Identifier: MIT
#include "pipeline/cli/kinds.h"

#include <algorithm>
#include <cctype>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/words.h"
#include "datasets/results/results_file.h"
#include "datasets/results/table.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/calibration_study/calibration_summary.h"
#include "pipeline/cli/embedded_campaigns.h"
#include "pipeline/cli/embedded_studies.h"
#include "pipeline/clocks/clocks_study.h"
#include "pipeline/sweep/sweep_spec.h"
#include "reports/render/render.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

std::function<int(const Shard&, bool, const RunControl&)> prints(Json plan, std::string text) {
  return [plan = std::move(plan), text = std::move(text)](const Shard&, bool json, const RunControl&) {
    fmt::print("{}\n", json ? json_text(plan, 2) : text);
    return int{kDone};
  };
}

// A campaign, or a folder of recordings without campaign.json, or one session.
Campaign recordings_of(const fs::path& of_study, const RunArguments& arguments) {
  const fs::path folder = arguments.campaign.empty() ? of_study : arguments.campaign;
  const bool is_session = kSessionEndings.contains(lower_extension(folder)) && fs::is_regular_file(folder);
  if (!is_session &&
      (!fs::is_directory(folder) || fs::exists(folder / "campaign.json") || fs::exists(folder / "items")))
    return campaign_of(of_study, arguments);
  Campaign campaign;
  campaign.name = fs::absolute(folder).lexically_normal().stem().string();
  campaign.folder = is_session ? folder.parent_path() : folder;
  for (const fs::path& file : is_session ? std::vector{folder} : files_below(folder, kSessionEndings)) {
    if (add_calibration_recording(file, campaign)) continue;
    Take& take = campaign.takes.emplace_back();
    take.id = is_session ? file.filename().string() : file.lexically_relative(folder).generic_string();
    take.session = file;
  }
  if (campaign.takes.empty() && !campaign.wand && campaign.stated_distances.empty() && campaign.walls.empty())
    throw InputError(folder.string(),
                     "holds no campaign.json and no recording (session.h5); `trilat record` makes one");
  return campaign;
}

OpenedStudy open_sweep(const RunArguments& arguments, const Json& study) {
  const SweepSpec spec = parse_sweep(study, arguments.study.string());
  const std::size_t cells = spec.cells.size();
  const std::size_t choices = cells / (spec.rigs.size() * spec.thresholds.size() * spec.ranges.size());
  return {.run = [spec, output = arguments.output](
                     const StudyOptions& options) { return run_sweep(spec, output, options); },
          .print_plan = prints(
              {{"study", json_of(spec)},
               {"simulated", true},
               {"cells", cells},
               {"trials", cells * spec.trials},
               {"skipped", spec.skipped}},
              fmt::format(
                  "study {} (simulated): {}, {}, {} and {} = {} x {} = {} trials; combinations skipped: {}",
                  spec.name, counted(spec.rigs.size(), "rig"), counted(spec.thresholds.size(), "threshold"),
                  counted(spec.ranges.size(), "error range"), counted(choices, "other choice"),
                  counted(cells, "cell"), counted(spec.trials, "trial"), cells * spec.trials, spec.skipped))};
}

// A study of the campaign's recordings.
template <class Spec>
OpenedStudy open_recordings(const RunArguments& arguments, const Spec& spec, const Campaign& campaign,
                            std::size_t items,
                            ItemCounts (*run)(const Spec&, const Campaign&, const fs::path&,
                                              const StudyOptions&)) {
  return {.run = [=, output = arguments.output](
                     const StudyOptions& options) { return run(spec, campaign, output, options); },
          .print_plan = prints(
              {{"study", json_of(spec)}, {"campaign", campaign.name}, {"items", items}},
              fmt::format("study {} on campaign {}: {}", spec.name, campaign.name, counted(items, "item"))),
          .inputs = inputs_of(campaign),
          .campaign = campaign};
}

OpenedStudy open_clocks(const RunArguments& arguments, const Json& study) {
  const ClocksSpec spec =
      read_as<ClocksSpec>(study, {arguments.study.string(), arguments.study.parent_path()});
  return open_recordings(arguments, spec, recordings_of(spec.campaign, arguments), 1, run_clocks);
}

// A session that is named alone shows a wand where its name says nothing else.
OpenedStudy open_calibration(const RunArguments& arguments, const Json& study) {
  const CalibrationSpec spec =
      read_as<CalibrationSpec>(study, {arguments.study.string(), arguments.study.parent_path()});
  Campaign campaign = recordings_of(spec.campaign, arguments);
  if (kSessionEndings.contains(lower_extension(arguments.campaign)) && !campaign.takes.empty())
    campaign.wand = {.session = campaign.takes.front().session};
  OpenedStudy opened =
      open_recordings(arguments, spec, campaign, calibration_recordings(spec, campaign), run_calibration);
  opened.print_failed = [](const ItemCounts& tally) {
    for (const auto& [id, outcome] : tally.failed)
      fmt::print(stderr, "failed: {}: {}\n", id, outcome.at("problem").get<std::string>());
  };
  return opened;
}

int print_tables(const std::filesystem::path& results, Json document, const PrintOptions& shown) {
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

// Names the recordings that could not be evaluated, on stderr.
int print_calibration(const fs::path& results, Json document, const PrintOptions& shown) {
  const auto failed = read_results<CalibrationSummary>(results).failed;
  for (const std::string& text : failed) fmt::print(stderr, "failed: {}\n", text);
  print_tables(results, std::move(document), shown);
  return failed.empty() ? kDone : kItemsFailed;
}

}  // namespace

bool add_calibration_recording(const fs::path& session, Campaign& campaign) {
  const fs::path folder = fs::absolute(session).lexically_normal().parent_path();
  const std::string name = session.stem() == "session" ? folder.filename().string() : session.stem().string();
  const auto is_called = [&](const std::string& word) {
    return name.starts_with(word) &&
           (name.size() == word.size() || !std::isalpha(static_cast<unsigned char>(name[word.size()])));
  };
  if (fs::exists(folder / "places.csv"))
    campaign.stated_distances.push_back({session, folder / "places.csv"});
  else if (is_called("wall"))
    campaign.walls.push_back({session});
  else if (!is_called("wand"))
    return false;
  else if (!campaign.wand)
    campaign.wand = {.session = session};
  return true;
}

std::vector<fs::path> files_below(const fs::path& folder, const std::set<std::string>& extensions) {
  std::vector<fs::path> files;
  auto entry = fs::recursive_directory_iterator(folder);
  for (; entry != fs::recursive_directory_iterator(); ++entry) {
    if (entry->is_directory() && fs::exists(entry->path() / "manifest.json"))
      entry.disable_recursion_pending();
    if (entry->is_regular_file() && extensions.contains(lower_extension(entry->path())))
      files.push_back(entry->path());
  }
  std::ranges::sort(files);
  return files;
}

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> kinds{
      {StudyKind::accuracy, "takes", "", open_accuracy, print_accuracy, schema_of<StudySpec>},
      {StudyKind::threshold_sweep, "items",
       "a threshold sweep makes its own trials and places its own sensors", open_sweep, print_tables,
       schema_of<SweepSpec>},
      {StudyKind::calibration, "items", "", open_calibration, print_calibration, schema_of<CalibrationSpec>},
      {StudyKind::clocks, "items", "", open_clocks, print_tables, schema_of<ClocksSpec>}};
  return kinds;
}

const Kind* find_kind(const std::string& name) {
  const auto found = std::find_if(kinds().begin(), kinds().end(),
                                  [&](const Kind& kind) { return name_of(kind.kind) == name; });
  return found == kinds().end() ? nullptr : &*found;
}

namespace {

constexpr std::size_t kWidest = 100;

void print_sentence(std::string sentence) {
  std::erase_if(sentence, [](char c) { return c == '*' || c == '`'; });
  for (const std::string& line : lines_of(sentence, kWidest)) fmt::print("{}\n", line);
}

}  // namespace

void print_stored(const std::filesystem::path& results, bool all) {
  const std::optional<StoredTables> stored = read_json_file<StoredTables>(results);
  if (!stored) throw InputError(results.string(), "has no tables.json; run the study again");
  print_sentence(stored->title + ": " + stored->about);
  for (const Table& table : stored->tables) {
    const bool is_first = table.shown == Table::Placement::first;
    if (all && table.shown != Table::Placement::file) fmt::print("\n{}", markdown_of(table));
    if (!all && is_first && !table.rows.empty()) fmt::print("\n{}", terminal_text(table, kWidest));
  }
  fmt::print("\n");
  for (const std::string& sentence : stored->sentences) print_sentence(sentence);
  for (const std::string& finding : stored->findings) print_sentence(finding);
  for (const std::string& warning : stored->warnings) print_sentence("warning: " + warning);
}

namespace {

template <class List>
Json document(const List& list, const std::string& name, const std::string& scale) {
  const auto found = std::ranges::find_if(list, [&](const auto& entry) { return entry.name == name; });
  TRILAT_CHECK(found != std::end(list), "a document that is built in has a name that is known");
  Json json = parse_json(found->text, "pipeline/studies/" + name + ".json");
  const Json scales = json.value("scales", Json::object());
  json.erase("scales");
  if (scales.contains(scale)) json.merge_patch(scales[scale]);
  return json;
}

}  // namespace

Json built_in_study(const std::string& name, const std::string& scale) {
  return document(embedded::studies, name, scale);
}
Json built_in_campaign(const std::string& name, const std::string& scale) {
  return document(embedded::campaigns, name, scale);
}

std::vector<std::string> built_in_studies() {
  std::vector<std::string> names;
  for (const auto& study : embedded::studies) names.emplace_back(study.name);
  return names;
}

namespace {

std::string some_of(const std::vector<std::string>& ids) {
  constexpr std::size_t kMaxNamed = 8;
  const std::size_t named = std::min(ids.size(), kMaxNamed);
  std::string text =
      fmt::format("{}", fmt::join(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(named), ", "));
  if (ids.size() > named) text += fmt::format(" and {} more", ids.size() - named);
  return text;
}

}  // namespace

Json tally_json(const ItemCounts& tally) {
  return {{"items", tally.all()},
          {"items_computed", tally.computed.size()},
          {"items_found", tally.found.size()},
          {"items_failed", tally.failed.size()},
          {"unchanged", tally.unchanged}};
}

void print_item_counts(const std::string& items, const ItemCounts& tally) {
  if (tally.unchanged) {
    fmt::print(stderr, "nothing changed: the results are there already\n");
    return;
  }
  for (const std::string& damage : tally.damaged)
    fmt::print(stderr, "computed again, because what was there is damaged: {}\n", damage);
  if (!tally.found.empty())
    fmt::print(stderr, "{} {} did not change and were there: {}\n", tally.found.size(), items,
               some_of(tally.found));
  if (!tally.computed.empty() && !tally.found.empty())
    fmt::print(stderr, "{} {} were computed: {}\n", tally.computed.size(), items, some_of(tally.computed));
}

void tell_interrupted(const std::filesystem::path& folder) {
  fmt::print(
      stderr,
      "trilat: interrupted; what was finished has been kept in {}, and the same command goes on from there\n",
      folder.string());
}

}  // namespace trilat
