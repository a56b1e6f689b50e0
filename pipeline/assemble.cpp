// SPDX-License-Identifier: MIT
#include "pipeline/assemble.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <mutex>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/replay.h"
#include "pipeline/manifest.h"
#include "pipeline/parallel.h"
#include "pipeline/replay_take.h"
#include "pipeline/summarise.h"
#include "pipeline/take_folder.h"
#include "pipeline/take_key.h"
#include "pipeline/watch.h"

namespace trilat {
namespace {

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

// Copies takes from where they are, one at a time, while the threads summarise others.
class Gatherer {
 public:
  Gatherer(const RunParts& parts, SamplesFile& samples, const std::function<bool()>& stop_requested)
      : parts_(parts),
        samples_(samples),
        stop_requested_(stop_requested),
        layout_(statistics_layout(parts.plan)) {}

  std::optional<TakeSummary> bring(std::size_t t) {
    if (stop_requested_ && stop_requested_()) throw Interrupted();
    const EvaluatedTake& take = parts_.takes[t];
    const std::lock_guard lock(mutex_);
    if (!take.result.evaluated) {
      copy_take(nullptr, 0, samples_, t);
      return TakeSummary{{}, empty_statistics(layout_, 0)};
    }
    const auto from = open_.try_emplace(take.folder, take.folder).first;
    const OpenSamples& there = from->second;
    check_shape(there, samples_.header(), t, (take.folder / "samples.h5").string());
    std::optional<TakeSummary> known;
    if (!parts_.summary_key.empty())
      known = read_take_summary(take.folder, parts_.summary_key, layout_, parts_.plan.takes[t].instants);
    copy_take(&there.file, there.number.at(samples_.header().takes[t].id), samples_, t);
    if (there.number.size() == 1) open_.erase(from);
    return known;
  }

 private:
  const RunParts& parts_;
  SamplesFile& samples_;
  const std::function<bool()>& stop_requested_;
  StatisticsLayout layout_;
  std::mutex mutex_;
  std::map<std::filesystem::path, OpenSamples> open_;  // of several takes, or of the one being copied
};

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

void summarise_takes(const Plan& plan, std::span<const std::size_t> takes,
                     const std::filesystem::path& folder, const std::string& key, StageTimes& times,
                     const SummariseHooks& hooks) {
  const RunningTime start;
  const StatisticsLayout layout = statistics_layout(plan);
  std::atomic<std::size_t> done{0};
  parallel_for_index(takes.size(), 1, [&](std::size_t k) {
    if (hooks.stop_requested && hooks.stop_requested()) throw Interrupted();
    const std::filesystem::path own = own_folder(folder, plan.takes[takes[k]].take.id);
    write_take_summary(own, key, summarise_take(SamplesFile::open(own / "samples.h5"), 0, layout));
    if (hooks.progress) hooks.progress(static_cast<double>(++done) / static_cast<double>(takes.size()));
  });
  times.summarise_s = start.seconds();
}

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
  const RunningTime start;
  SamplesFile samples = SamplesFile::create(folder / "samples.h5", samples_header(parts.plan));
  const RunOutcome outcome = outcome_of(parts.plan, parts.takes, parts.cross_check);
  Gatherer gatherer(parts, samples, options.stop_requested);
  const ResultsSummary summary = summarise(
      parts.plan, outcome, samples, [&](std::size_t t) { return gatherer.bring(t); },
      std::min(kDistancesInMemoryBytes, options.memory_bytes / 2), options.progress);
  times.summarise_s = start.seconds();
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
