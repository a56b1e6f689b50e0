// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_study.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <type_traits>

#include <fmt/format.h>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "pipeline/calibration/wand_search.h"

namespace trilat {

namespace {

namespace fs = std::filesystem;

// Costs are in depth frames that are searched in the same time.
constexpr const char* kMocapItem = "wand/mocap";
constexpr double kMocapCost = 100.0;
constexpr double kHashedBytes = 4e6;

std::string hash_item(std::size_t recording) { return fmt::format("wand/r{}-sha256", recording + 1); }

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
      items[r].push_back({run, fmt::format("wand/r{}-s{}-f{}", r + 1, run.sensor + 1, run.first)});
  }
  return items;
}

// All that the items need while they are computed.
struct WandSearch {
  WandWork work;
  WatchedFiles watched;
  std::vector<SessionReader> sessions;
  std::vector<std::unique_ptr<WandSearcher>> searchers;  // by recording
};

// The outcome, made of files that did not change meanwhile.
Json unchanged(const WandSearch& search, Json outcome) {
  search.watched.check();
  return outcome;
}

Item mocap_item(const std::shared_ptr<const WandSearch>& search) {
  const WandWork& work = search->work;
  const Json settings{{"mocap", work.other_sources.front().sha256}, {"asset", work.options.world->asset}};
  return {kMocapItem, kMocapCost,
          [search](const fs::path&, const Watch&) {
            const WandInWorld& world = *search->work.options.world;
            return unchanged(*search, json_of(read_wand_track(world.mocap, world.asset)));
          },
          [settings](const Watch&) { return key_of(settings); }};
}

Item hash_item(const std::shared_ptr<const WandSearch>& search, std::size_t r) {
  const WandRecording& recording = search->work.recordings[r];
  // the fingerprint leaves out what no search depends on, and the hash is of all of it
  const auto identity = identity_of(recording.place);
  const Json settings{{"recording", recording.fingerprint}, {"changed", identity ? identity->changed : ""}};
  return {hash_item(r), 1.0 + static_cast<double>(recording.bytes) / kHashedBytes,
          [search, &recording](const fs::path&, const Watch& watch) {
            return unchanged(*search, {{"sha256", hash_of_file(recording.place, watch.stop_requested)}});
          },
          [settings](const Watch&) { return key_of(settings); }};
}

Item search_item(const std::shared_ptr<const WandSearch>& search, std::size_t r, const RunItem& item) {
  const WandRecording& recording = search->work.recordings[r];
  // all that the sightings depend on, besides the program
  const Json settings{{"recording", recording.fingerprint},
                      {"intrinsics", json_of(recording.sensors[item.run.sensor].intrinsics)},
                      {"ball_radius_m", search->work.options.search.find.ball_radius_m},
                      {"sensor", item.run.sensor},
                      {"frames", {item.run.first, item.run.count}}};
  return {item.id, static_cast<double>(item.run.count),
          [search, r, run = item.run](const fs::path&, const Watch& watch) {
            return unchanged(*search, json_of(search->searchers[r]->search(run, watch)));
          },
          [settings](const Watch&) { return key_of(settings); }};
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
  std::vector<std::string> ids;
  if (work.options.world) ids.push_back(kMocapItem);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    ids.push_back(hash_item(r));
    for (const RunItem& item : runs[r]) ids.push_back(item.id);
  }
  const auto same = [](const std::string& id, const PartItem& item) { return id == item.id; };
  if (!std::equal(ids.begin(), ids.end(), part.part.items.begin(), part.part.items.end(), same)) refuse();
  return runs;
}

std::string sha256_in(const Outcome& outcome) {
  const Json json = outcome.json();
  JsonObject object(json, outcome.place(), "");
  std::string sha256 = object.text("sha256");
  object.finish();
  return sha256;
}

SensorSearch search_in(const Outcome& outcome, const RunItem& item) {
  SensorSearch search = read_sensor_search(outcome.json(), outcome.place());
  if (search.frames != item.run.count)
    throw InputError(outcome.place(),
                     fmt::format("is of {} frames, not of {}", search.frames, item.run.count));
  return search;
}

constexpr std::uint64_t kDepthFrameEvery = 1200;
constexpr std::uint64_t kStampsAtOnce = 65536;

template <class Rows>
void add_rows(ContentHash& hash, const Rows& rows) {
  static_assert(std::has_unique_object_representations_v<typename Rows::value_type>);
  const std::uint64_t count = rows.size();
  hash.add(&count, sizeof count);
  hash.add(rows.data(), rows.size() * sizeof(typename Rows::value_type));
}

void add_stamps(ContentHash& hash, const SessionReader& session, std::size_t sensor, FrameStream stream,
                std::uint64_t frames) {
  for (std::uint64_t first = 0; first < frames; first += kStampsAtOnce)
    add_rows(hash, session.stamps(sensor, stream, first, std::min(kStampsAtOnce, frames - first)));
}

}  // namespace

Study wand_study(const std::vector<fs::path>& files, WandMethod method, const CalibrateWandOptions& options,
                 std::uint64_t frames_of_item) {
  const auto search = std::make_shared<WandSearch>();
  search->watched = watched_files(files, options);
  search->sessions = open_sessions(files);
  search->work = make_wand_work(search->sessions, method, options);
  WandWork& work = search->work;
  work.frames_of_item = frames_of_item;
  for (std::size_t r = 0; r < search->sessions.size(); ++r) {
    work.recordings[r].fingerprint = fingerprint_of(search->sessions[r]);
    search->searchers.push_back(std::make_unique<WandSearcher>(
        search->sessions[r], intrinsics_of(work.recordings[r]), work.options.search));
  }
  search->watched.check();
  Study study{.kind = kWandSearch, .work = json_of(work), .reduce = {}};
  if (work.options.world) study.items.push_back(mocap_item(search));
  const auto runs = run_items(work);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    study.items.push_back(hash_item(search, r));
    for (const RunItem& item : runs[r]) study.items.push_back(search_item(search, r, item));
  }
  return study;
}

WandCalibration calibrate_parts(const std::vector<FoundPart>& parts) {
  const FoundPart& first = parts.front();
  WandWork work = read_wand_work(first.part.work, (first.folder / "part.json").string());
  const auto runs = run_items(work, first);
  const Outcomes outcomes = outcomes_of(parts);
  if (work.options.world) {
    const Outcome& mocap = outcomes.at(kMocapItem);
    work.options.world->track = wand_track_of(mocap.json(), mocap.place());
  }
  std::vector<std::vector<SensorSearch>> searches;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    work.recordings[r].sha256 = sha256_in(outcomes.at(hash_item(r)));
    searches.emplace_back(work.recordings[r].sensors.size());
    for (const RunItem& item : runs[r])
      append(searches[r][item.run.sensor], search_in(outcomes.at(item.id), item));
  }
  return calibrate_searched(work, searches);
}

std::string fingerprint_of(const SessionReader& session) {
  ContentHash hash;
  add_rows(hash, std::array{std::uint64_t{std::filesystem::file_size(session.path())}});
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    const SensorDescription& sensor = session.header().sensors[s];
    const SensorCounts& counts = session.counts(s);
    for (const std::string& text : {sensor.name, sensor.serial, sensor.source}) add_rows(hash, text);
    add_rows(hash, std::array{sensor.tick_ns, sensor.latency_ns});
    add_rows(hash, std::array{counts.body_frames, counts.depth_frames});
    add_stamps(hash, session, s, FrameStream::bodies, counts.body_frames);
    add_stamps(hash, session, s, FrameStream::depth, counts.depth_frames);
    add_rows(hash, session.clock_exchanges(s));
    for (std::uint64_t frame = 0; frame < counts.depth_frames; frame += kDepthFrameEvery)
      add_rows(hash, session.stored_depth_frame(s, frame).chunk);
  }
  return hash.finish();
}

}  // namespace trilat
