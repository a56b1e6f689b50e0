// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/gather_takes.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "datasets/base/error.h"
#include "datasets/results/replay.h"
#include "datasets/results/samples.h"
#include "datasets/results/summary.h"
#include "pipeline/accuracy/evaluate_take.h"
#include "pipeline/accuracy/statistics/summarise.h"

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
  Gatherer(std::span<const EvaluatedTake> takes, SamplesFile& samples, const Watch& watch)
      : takes_(takes), samples_(samples), watch_(watch) {}

  void bring(std::size_t t) {
    watch_.check();
    const EvaluatedTake& take = takes_[t];
    const std::lock_guard lock(mutex_);
    if (!take.result.evaluated) {
      copy_take(nullptr, 0, samples_, t);
      return;
    }
    const auto from = open_.try_emplace(take.folder, take.folder).first;
    const OpenSamples& there = from->second;
    check_shape(there, samples_.header(), t, (take.folder / "samples.h5").string());
    copy_take(&there.file, there.number.at(samples_.header().takes[t].id), samples_, t);
    if (there.number.size() == 1) open_.erase(from);
  }

 private:
  std::span<const EvaluatedTake> takes_;
  SamplesFile& samples_;
  const Watch& watch_;
  std::mutex mutex_;
  std::map<std::filesystem::path, OpenSamples> open_;  // of several takes, or of the one being copied
};

ReplayTake replay_in(const std::filesystem::path& folder, const std::string& id) {
  std::vector<ReplayTake> there = read_replay(folder);
  const auto found = std::ranges::find_if(there, [&](const ReplayTake& r) { return r.id == id; });
  if (found == there.end())
    throw InputError((folder / "replay.h5").string(), "has no replay of the take \"" + id + '"');
  return std::move(*found);
}

std::vector<ReplayTake> gather_replays(const Plan& plan, std::span<const EvaluatedTake> takes) {
  std::vector<ReplayTake> replays;
  for (std::size_t t = 0; t < takes.size(); ++t) {
    if (!takes[t].result.evaluated || !is_replayed(plan, t)) continue;
    replays.push_back(replay_in(takes[t].folder, plan.takes[t].take.id));
    replays.back().take = t;
  }
  return replays;
}

}  // namespace

void gather_takes(const Plan& plan, std::span<EvaluatedTake> takes, bool cross_check,
                  const std::filesystem::path& results, const Watch& watch) {
  SamplesFile samples = SamplesFile::create(results / "samples.h5", samples_header(plan));
  const RunOutcome outcome = outcome_of(plan, takes, cross_check);
  std::vector<std::optional<TakeSummary>> known;
  for (EvaluatedTake& take : takes) known.push_back(std::exchange(take.summary, {}));
  Gatherer gatherer(takes, samples, watch);
  const ResultsSummary summary = summarise(
      plan, outcome, samples, std::move(known), [&](std::size_t t) { gatherer.bring(t); }, watch.progress);
  samples.finish();
  write_summary(results, summary);
  write_beside(results, outcome.tracking);
  if (const auto replays = gather_replays(plan, takes); !replays.empty()) write_replay(results, replays);
}

}  // namespace trilat
