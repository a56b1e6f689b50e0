// SPDX-License-Identifier: MIT
#include "pipeline/assemble.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <map>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/replay.h"
#include "pipeline/manifest.h"
#include "pipeline/replay_take.h"
#include "pipeline/summarise.h"
#include "pipeline/take_key.h"

namespace trilat {
namespace {

constexpr double kCopyShare = 0.3;           // of the progress; the rest is the summary
constexpr std::uint64_t kBlockRows = 65536;  // samples that are copied at once

// The samples file of one folder, and which of its takes is which.
struct OpenSamples {
  SamplesFile file;
  std::map<std::string, std::size_t> number;

  explicit OpenSamples(const std::filesystem::path& folder) : file(SamplesFile::open(folder / "samples.h5")) {
    for (std::size_t t = 0; t < file.header().takes.size(); ++t) number[file.header().takes[t].id] = t;
  }
};

// Fills a take's slots with its samples, or with "not solved" when there are none.
void copy_take(const SamplesFile* from, std::size_t number, SamplesFile& to, std::size_t take) {
  const SamplesHeader& header = to.header();
  const std::uint64_t instants = header.takes[take].instants;
  const std::uint64_t step = std::max<std::uint64_t>(
      1, kBlockRows / std::max<std::size_t>(1, header.joints.size() * header.methods.size()));
  SampleBlock block;
  for (std::uint64_t first = 0; first < instants; first += step) {
    const std::uint64_t count = std::min(step, instants - first);
    if (from)
      from->read(number, first, count, SampleColumns::all, block);
    else
      block.reset(first, count, header.joints.size(), header.methods.size());
    to.write(take, block);
  }
}

void check_shape(const OpenSamples& from, const SamplesHeader& wanted, std::size_t take,
                 const std::string& place) {
  const auto found = from.number.find(wanted.takes[take].id);
  if (found == from.number.end())
    throw InputError(place, "has no samples of the take \"" + wanted.takes[take].id + '"');
  const SamplesHeader& there = from.file.header();
  if (there.takes[found->second].instants != wanted.takes[take].instants || there.joints != wanted.joints ||
      there.methods != wanted.methods || there.status_names != wanted.status_names)
    throw InputError(place, "has samples of another shape of the take \"" + wanted.takes[take].id + '"');
}

// Takes that lie in one folder follow each other more often than not, so one folder is open at a time.
SamplesFile gather_samples(const RunParts& parts, const std::filesystem::path& folder,
                           const AssembleOptions& options) {
  SamplesFile samples = SamplesFile::create(folder / "samples.h5", samples_header(parts.plan));
  std::optional<OpenSamples> from;
  std::filesystem::path open_folder;
  for (std::size_t t = 0; t < parts.takes.size(); ++t) {
    if (options.stop_requested && options.stop_requested()) throw Interrupted();
    const EvaluatedTake& take = parts.takes[t];
    if (take.result.evaluated) {
      if (!from || open_folder != take.folder) from.emplace(take.folder);
      open_folder = take.folder;
      check_shape(*from, samples.header(), t, (take.folder / "samples.h5").string());
      copy_take(&from->file, from->number.at(samples.header().takes[t].id), samples, t);
    } else {
      copy_take(nullptr, 0, samples, t);
    }
    if (options.progress)
      options.progress(kCopyShare * static_cast<double>(t + 1) / static_cast<double>(parts.takes.size()));
  }
  return samples;
}

ReplayTake replay_in(const std::filesystem::path& folder, const std::string& id) {
  std::vector<ReplayTake> there = read_replay(folder);
  const auto found =
      std::find_if(there.begin(), there.end(), [&](const ReplayTake& r) { return r.id == id; });
  if (found == there.end())
    throw InputError((folder / "replay.h5").string(), "has no replay of the take \"" + id + '"');
  return std::move(*found);
}

std::vector<ReplayTake> gather_replays(const RunParts& parts) {
  std::vector<ReplayTake> replays;
  for (std::size_t t = 0; t < parts.takes.size(); ++t) {
    if (!parts.takes[t].result.evaluated || !is_replayed(parts.plan, t)) continue;
    replays.push_back(replay_in(parts.takes[t].folder, parts.plan.takes[t].take.id));
    replays.back().take = t;
  }
  return replays;
}

RunIdentity identity_of(const RunParts& parts) {
  RunIdentity run{parts.plan.study,
                  parts.cross_check,
                  parts.plan.campaign.name,
                  parts.plan.campaign.simulated,
                  parts.parameters,
                  parts.plan.campaign.takes,
                  {}};
  for (const EvaluatedTake& take : parts.takes) run.inputs.push_back(take.result.inputs);
  return run;
}

}  // namespace

void copy_samples(const Plan& plan, std::size_t take, const std::filesystem::path& from,
                  const std::filesystem::path& to) {
  std::filesystem::remove_all(to);
  make_folder(to);
  const OpenSamples earlier(from);
  SamplesFile samples = SamplesFile::create(to / "samples.h5", samples_header(plan, std::array{take}));
  check_shape(earlier, samples.header(), 0, (from / "samples.h5").string());
  const std::string& id = plan.takes[take].take.id;
  copy_take(&earlier.file, earlier.number.at(id), samples, 0);
  samples.finish();
  if (is_replayed(plan, take)) write_replay(to, std::array{replay_in(from, id)});
}

std::vector<DoneItem> items_of(const Plan& plan, std::span<const EvaluatedTake> takes) {
  std::vector<DoneItem> items;
  for (std::size_t t = 0; t < takes.size(); ++t)
    items.push_back({plan.takes[t].take.id, takes[t].key, json_of(takes[t].result)});
  return items;
}

ResultsSummary assemble(const RunParts& parts, const std::filesystem::path& folder, StageTimes& times,
                        const AssembleOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  SamplesFile samples = gather_samples(parts, folder, options);
  const RunOutcome outcome = outcome_of(parts.plan, parts.takes, parts.cross_check);
  const ResultsSummary summary =
      summarise(parts.plan, outcome, samples, std::min(kDistancesInMemoryBytes, options.memory_bytes / 2),
                [&](double share) {
                  if (options.progress) options.progress(kCopyShare + (1.0 - kCopyShare) * share);
                });
  times.summarise_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  samples.finish();
  write_manifest(folder, parts.plan, parts.takes);
  write_summary(folder, summary);
  write_tracking_summary(folder, outcome.tracking);
  if (parts.gdop) write_gdop_map(folder, *parts.gdop);
  if (const auto replays = gather_replays(parts); !replays.empty()) write_replay(folder, replays);
  if (!parts.parameters.empty()) write_declared_parameters(folder, parts.parameters);
  // a run that had failures is not said to be the same as another: what failed may work now
  const bool all =
      std::all_of(parts.takes.begin(), parts.takes.end(), [](const auto& t) { return t.result.evaluated; });
  write_items(folder, items_of(parts.plan, parts.takes), all ? key_of_run(identity_of(parts)) : "");
  return summary;
}

}  // namespace trilat
