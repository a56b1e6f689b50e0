// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_part.h"

#include <algorithm>
#include <atomic>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "pipeline/calibration/session_fingerprint.h"
#include "pipeline/calibration/wand_outcome.h"
#include "pipeline/items/study_items.h"
#include "pipeline/parallel.h"
#include "pipeline/results_folder.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

// Costs are in depth frames that are searched in the same time.
constexpr const char* kMocapItem = "mocap";
constexpr std::uint64_t kMocapCost = 100;
constexpr std::uint64_t kHashedBytes = 4'000'000;

std::string hash_item(std::size_t recording) { return fmt::format("r{}-sha256", recording + 1); }

std::uint64_t hash_cost(const WandRecording& recording) { return 1 + recording.bytes / kHashedBytes; }

// A run of frames of one recording's sensor.
struct RunItem {
  FrameRun run;
  std::string id;
};

// One entry a recording.
std::vector<std::vector<RunItem>> run_items(const WandWork& work) {
  std::vector<std::vector<RunItem>> items(work.recordings.size());
  for (std::size_t r = 0; r < items.size(); ++r) {
    std::vector<std::uint64_t> frames;
    for (const RecordedSensor& sensor : work.recordings[r].sensors) frames.push_back(sensor.frames);
    for (const FrameRun& run : runs_of(frames, work.frames_of_item))
      items[r].push_back({run, fmt::format("r{}-s{}-f{}", r + 1, run.sensor + 1, run.first)});
  }
  return items;
}

std::vector<PartItem> part_items(const WandWork& work, const std::vector<std::vector<RunItem>>& runs) {
  std::vector<PartItem> items;
  if (work.options.world) items.push_back({kMocapItem, double{kMocapCost}});
  for (std::size_t r = 0; r < runs.size(); ++r) {
    items.push_back({hash_item(r), static_cast<double>(hash_cost(work.recordings[r]))});
    for (const RunItem& item : runs[r]) items.push_back({item.id, static_cast<double>(item.run.count)});
  }
  return items;
}

// What this shard has done of its share.
class SharedProgress {
 public:
  SharedProgress(const std::vector<PartItem>& items, const Shard& shard,
                 const std::function<void(double)>& report)
      : report_(report) {
    std::vector<double> costs;
    for (const PartItem& item : items) costs.push_back(item.cost);
    const std::vector<std::uint64_t> owner = shards_of(costs, shard.of);
    for (std::size_t i = 0; i < items.size(); ++i) all_ += owner[i] == shard.number ? costs[i] : 0.0;
  }
  void add(std::uint64_t cost) {
    const double done = static_cast<double>(done_ += cost);
    if (report_) report_(std::min(1.0, done / all_));
  }

 private:
  const std::function<void(double)>& report_;
  double all_ = 0.0;
  std::atomic<std::uint64_t> done_{0};
};

// The items of one recording that are this shard's.
void search_recording(const WandWork& work, std::size_t r, const SessionReader& session,
                      const std::vector<RunItem>& runs, const WatchedFiles& watched, StudyItems& items,
                      SharedProgress& progress) {
  const WandRecording& recording = work.recordings[r];
  WandSearcher searcher(session, intrinsics_of(recording), work.options.search);
  const auto hash = [&] {
    const auto compute = [&] {
      std::string sha256 = hash_of_file(recording.place, work.options.search.stop_requested);
      watched.check();
      return Json{{"sha256", std::move(sha256)}};
    };
    // the fingerprint leaves out what no search depends on, and the hash is of all of it
    const auto identity = identity_of(recording.place);
    const Json settings{{"recording", recording.fingerprint}, {"changed", identity ? identity->changed : ""}};
    if (items.outcome(hash_item(r), compute, {.settings = settings})) progress.add(hash_cost(recording));
  };
  const auto search = [&](const RunItem& item) {
    bool searched = false;
    const auto compute = [&] {
      searched = true;
      Json found = json_of(searcher.search(item.run, [&](std::uint64_t frames) { progress.add(frames); }));
      watched.check();
      return found;
    };
    // all that the sightings depend on, besides the program
    const Json settings{{"recording", recording.fingerprint},
                        {"intrinsics", json_of(recording.sensors[item.run.sensor].intrinsics)},
                        {"ball_radius_m", work.options.search.find.ball_radius_m},
                        {"frames", item.run.count}};
    if (items.outcome(item.id, compute, {.settings = settings}) && !searched) progress.add(item.run.count);
  };
  parallel_for_index(runs.size() + 1, 1, [&](std::size_t i) { i == 0 ? hash() : search(runs[i - 1]); });
}

// Of a part, whose list of items must be that which its work is divided into.
std::vector<std::vector<RunItem>> run_items(const WandWork& work, const FoundPart& part) {
  const auto refuse = [&] {
    throw InputError((part.folder / "part.json").string(),
                     "/items: are not those that its work is divided into");
  };
  for (const WandRecording& recording : work.recordings)
    for (const RecordedSensor& sensor : recording.sensors)
      if (sensor.frames / work.frames_of_item > part.part.items.size()) refuse();
  std::vector<std::vector<RunItem>> runs = run_items(work);
  const std::vector<PartItem> items = part_items(work, runs);
  const auto same = [](const PartItem& a, const PartItem& b) { return a.id == b.id; };
  if (!std::equal(items.begin(), items.end(), part.part.items.begin(), part.part.items.end(), same)) refuse();
  return runs;
}

// What the parts hold, each item with the place for errors.
class HeldOutcomes {
 public:
  explicit HeldOutcomes(const std::vector<FoundPart>& parts) : items_(parts) {}
  Json outcome(const std::string& id) { return *items_.outcome(id, {}); }
  std::string place(const std::string& id) const { return items_.place_of(id); }

  WandTrack track() { return wand_track_of(outcome(kMocapItem), place(kMocapItem)); }
  std::string sha256(std::size_t recording) {
    const std::string id = hash_item(recording);
    const Json json = outcome(id);
    JsonObject object(json, place(id), "");
    std::string sha256 = object.text("sha256");
    object.finish();
    return sha256;
  }
  SensorSearch search(const RunItem& item) {
    SensorSearch search = read_sensor_search(outcome(item.id), place(item.id));
    if (search.frames != item.run.count)
      throw InputError(place(item.id),
                       fmt::format("is of {} frames, not of {}", search.frames, item.run.count));
    return search;
  }

 private:
  StudyItems items_;
};

}  // namespace

ItemTally search_wand_part(const std::vector<fs::path>& files, WandMethod method,
                           const CalibrateWandOptions& options, const Shard& shard, const fs::path& output,
                           std::uint64_t frames_of_item) {
  const WatchedFiles watched = watched_files(files, options);
  const std::vector<SessionReader> sessions = open_sessions(files);
  WandWork work = make_wand_work(sessions, method, options);
  work.frames_of_item = frames_of_item;
  for (std::size_t r = 0; r < sessions.size(); ++r)
    work.recordings[r].fingerprint = fingerprint_of(sessions[r]);
  watched.check();
  const auto runs = run_items(work);
  const std::vector<PartItem> all = part_items(work, runs);
  const ResultsFolder folder(output, {ItemJournal::kFile});
  std::vector<fs::path> earlier;
  if (fs::is_directory(folder.output())) earlier.push_back(folder.output());
  StudyItems items(kWandPart, json_of(work), all, folder.partial(), {shard, earlier});
  SharedProgress progress(all, shard, options.search.progress);
  if (const auto& world = work.options.world)
    items.outcome(kMocapItem,
                  [&] {
                    Json track = json_of(read_wand_track(world->mocap, world->asset));
                    watched.check();
                    return track;
                  },
                  {.settings = Json{{"mocap", work.other_sources.front().sha256}, {"asset", world->asset}}});
  for (std::size_t r = 0; r < runs.size(); ++r)
    search_recording(work, r, sessions[r], runs[r], watched, items, progress);
  items.finish(folder.partial(), "");
  folder.put_in_place();
  return items.tally();
}

WandCalibration merge_wand_parts(const std::vector<FoundPart>& parts) {
  const FoundPart& first = parts.front();
  WandWork work = read_wand_work(first.part.work, (first.folder / "part.json").string());
  const auto runs = run_items(work, first);
  HeldOutcomes held(parts);
  if (work.options.world) work.options.world->track = held.track();
  std::vector<std::vector<SensorSearch>> searches;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    work.recordings[r].sha256 = held.sha256(r);
    searches.emplace_back(work.recordings[r].sensors.size());
    for (const RunItem& item : runs[r]) append(searches[r][item.run.sensor], held.search(item));
  }
  return calibrate_searched(work, searches);
}

}  // namespace trilat
