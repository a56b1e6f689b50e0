// SPDX-License-Identifier: MIT
// `trilat record`.
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/calibration/calibration.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/terminal/skeleton_preview.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/simulate/simulate_take.h"
#include "recorders/capture.h"
#include "recorders/frame_source.h"
#include "recorders/network/network_source.h"
#include "recorders/open_source.h"

namespace trilat {
namespace {

struct RecordArguments {
  std::vector<std::string> sources;
  std::string listen;  // HOST:PORT, or empty
  std::size_t agents = 1;
  double wait_s = 60.0;
  std::string keys;
  bool plain_text = false;
  std::filesystem::path output;
  double duration_s = 0.0;
  std::string compression = "blosc";
  int queue_mb = 512;
  int reserve_mb = 256;
  int workers = 2;
  bool preview = false;
  std::filesystem::path calibration;
  std::filesystem::path truth;
  bool force = false;  // may replace what others wrote
  bool json = false;
};

// Status of a running recording on stderr: a line over itself on a terminal, now and then elsewhere, with
// notices above it. A thread of its own writes it, so that a terminal that takes nothing does not hold up the
// recording; what cannot be written is left out. Any thread may call it.
class LiveDisplay {
 public:
  LiveDisplay() : shared_(std::make_shared<Shared>()) {
    std::thread([shared = shared_] { shared->run(); }).detach();
  }
  // Waits a moment for what is still to be shown.
  ~LiveDisplay() {
    std::unique_lock lock(shared_->mutex);
    shared_->ended = true;
    shared_->changed.notify_all();
    shared_->changed.wait_for(lock, std::chrono::seconds(1), [&] { return shared_->done; });
  }
  LiveDisplay(const LiveDisplay&) = delete;
  LiveDisplay& operator=(const LiveDisplay&) = delete;

  // `picture` is drawn over the whole screen first.
  void show(const CaptureStatus& status, std::string picture = {});
  void say(const std::string& text);

 private:
  // Outlives the display when its thread is stuck in a terminal.
  struct Shared {
    std::mutex mutex;
    std::condition_variable changed;
    std::deque<std::string> texts, recent;  // recent: what stays below a picture
    std::string picture, line;
    bool line_changed = false, ended = false, done = false;
    const bool terminal = ::isatty(STDERR_FILENO) == 1;
    double next_s = 0.0;

    std::string below_picture() const {
      std::string text;
      for (const std::string& one : recent) text += picture.empty() ? "" : one + "\n";
      return text;
    }

    void run() {
      std::unique_lock lock(mutex);
      for (bool last = false; !last; lock.lock()) {
        changed.wait(lock, [&] { return !texts.empty() || line_changed || ended; });
        std::string out;
        if (terminal) out += "\r\033[K";
        for (const std::string& text : texts) out += text + "\n";
        texts.clear();
        if (line_changed && !ended) out += picture + below_picture() + line + (terminal ? "" : "\n");
        line_changed = false;
        last = ended;
        lock.unlock();
        std::fputs(out.c_str(), stderr);  // a failure here cannot be reported
        std::fflush(stderr);
      }
      done = true;
      changed.notify_all();
    }
  };
  std::shared_ptr<Shared> shared_;
};

// The line itself.
std::string status_line(const CaptureStatus& status) {
  const double written =
      status.elapsed_s > 0.0 ? static_cast<double>(status.file_bytes) / status.elapsed_s : 0.0;
  std::string line = fmt::format("{:4.0f} s ", status.elapsed_s);
  std::int64_t lost = 0;
  for (const SensorStatus& s : status.sensors) {
    line += fmt::format(" {} {:.1f} Hz", s.name, s.rate_hz);
    lost += s.lost_at_source + s.lost_in_queue;
  }
  line += fmt::format(
      "  lost {}  queue {:.0f} %  {:.1f} MB/s  {:.1f} GB free", lost,
      100.0 * static_cast<double>(status.queue_bytes) / static_cast<double>(status.queue_limit_bytes),
      1e-6 * written, 1e-9 * static_cast<double>(status.disk_free_bytes));
  if (written > 0.0)
    line += fmt::format(" ({:.0f} min)", static_cast<double>(status.disk_free_bytes) / written / 60.0);
  return line;
}

void LiveDisplay::show(const CaptureStatus& status, std::string picture) {
  constexpr double kLinePeriod_s = 10.0;  // where lines stay
  const std::lock_guard lock(shared_->mutex);
  if (!shared_->terminal && status.elapsed_s < shared_->next_s) return;
  shared_->next_s = status.elapsed_s + kLinePeriod_s;
  shared_->picture = std::move(picture);
  shared_->line = status_line(status);
  shared_->line_changed = true;
  shared_->changed.notify_all();
}

void LiveDisplay::say(const std::string& text) {
  constexpr std::size_t kMostTexts = 200;  // while the terminal takes nothing
  const std::lock_guard lock(shared_->mutex);
  if (shared_->texts.size() < kMostTexts) shared_->texts.push_back(text);
  constexpr std::size_t kMostBelow = 4;
  shared_->recent.push_back(text);
  if (shared_->recent.size() > kMostBelow) shared_->recent.pop_front();
  shared_->changed.notify_all();
}

constexpr double kDefaultDuration_s = 60.0;

const std::vector<Joint> kMarkerJoints{Joint::head,       Joint::shoulder_left, Joint::shoulder_right,
                                       Joint::elbow_left, Joint::elbow_right,   Joint::wrist_left,
                                       Joint::wrist_right};

// Truth of a recording of `synthetic` sensors, so that it can be evaluated: the
// OptiTrack export, the mapping and the sensors' true poses. The export is written before the recording
// starts and covers `duration_s` of it, or a minute. InputError unless there is one source, a synthetic one
// at real speed.
void write_truth(const std::vector<std::string>& sources, const std::filesystem::path& folder,
                 double duration_s) {
  const auto request = sources.size() == 1 ? synthetic_request(sources[0]) : std::nullopt;
  if (!request || request->live.speed != 1.0)
    throw InputError("--truth", "is known of one synthetic source at real speed only: --source synthetic:4");
  const SyntheticSetup setup = setup_of(*request);
  SimulatedTakePlan plan;
  plan.id = "take";
  plan.item = setup.item;
  plan.motion = setup.motion;
  plan.duration_s = duration_s > 0.0 ? duration_s : kDefaultDuration_s;
  plan.marker_joints = kMarkerJoints;
  make_folder(folder);
  Calibration poses{kSimulatedTruth, {}};
  poses.simulated = true;
  for (const SimulatedSensor& sensor : setup.sensors) poses.sensors.push_back(sensor.pose);
  write_calibration(folder / "calibration.json", poses);
  write_simulated_mocap(setup.simulation.mocap, plan, folder, stop_requested);
  write_mapping(folder / "mapping.json", marker_mapping(kMarkerJoints));
}

// Starts the source and writes the campaign, whose one take is the recording.
void write_campaign_of(FrameSource& source, const std::filesystem::path& session,
                       const std::filesystem::path& folder) {
  auto* live = dynamic_cast<LiveSource*>(&source);
  if (!live) return;
  const Take take{"take",
                  "p01",
                  "walking",
                  std::filesystem::absolute(session),
                  folder / "calibration.json",
                  folder / "mocap.csv",
                  folder / "mapping.json",
                  live->start(),
                  {}};
  write_campaign(folder, {"recorded", true, {take}, folder});
}

// Holds the name of an output that takes long to come, so that no other process takes it meanwhile: the file
// under its unfinished name, empty until somebody writes it. An empty one is removed in the end. InputError
// where that name exists.
class OutputClaim {
 public:
  explicit OutputClaim(const std::filesystem::path& output) : partial_(partial_name(output)) {
    check_output_file(output);
    const int file = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file >= 0) {
      ::close(file);
      return;
    }
    if (errno != EEXIST)
      throw OutputError(partial_.string(), std::string("cannot be created: ") + std::strerror(errno));
    throw InputError(partial_.string(), has_no_bytes()
                                            ? "exists and is empty: another recorder waits with this name, "
                                              "or was killed while it waited; then remove it"
                                            : "exists; another recorder writes it, or was killed: then "
                                              "`trilat recover` it, or take another name");
  }
  ~OutputClaim() {
    std::error_code ignored;
    if (has_no_bytes()) std::filesystem::remove(partial_, ignored);
  }
  OutputClaim(const OutputClaim&) = delete;
  OutputClaim& operator=(const OutputClaim&) = delete;

 private:
  bool has_no_bytes() const {
    std::error_code error;
    return std::filesystem::file_size(partial_, error) == 0 && !error;
  }

  std::filesystem::path partial_;
};

ChunkCompression compression_named(const std::string& name) {
  return name == "deflate" ? ChunkCompression::deflate
         : name == "none"  ? ChunkCompression::none
                           : ChunkCompression::blosc;
}

// Both clocks at once, so that somebody can tell later when the host clock's times were.
std::string utc_now() {
  const auto now = std::chrono::system_clock::now();
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}Z at host clock {} ns",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(now)), steady_now_ns());
}

const char* name_of(CaptureEnd end) {
  constexpr std::array kNames{"source_ended", "stop_requested", "duration_over", "disk_full", "disk_failed"};
  return kNames.at(static_cast<std::size_t>(end));
}

Json json_of(const CaptureSummary& summary, const std::filesystem::path& file) {
  Json sensors = Json::array();
  for (const SensorStatus& s : summary.last.sensors)
    sensors.push_back({{"name", s.name},
                       {"body_frames", s.body_frames},
                       {"depth_frames", s.depth_frames},
                       {"lost_at_source", s.lost_at_source},
                       {"lost_in_queue", s.lost_in_queue}});
  return {{"session", file.string()},
          {"end", name_of(summary.end)},
          {"elapsed_s", summary.last.elapsed_s},
          {"file_bytes", summary.last.file_bytes},
          {"source_failed", summary.source_failed},
          {"sensors", sensors}};
}

void print_summary(const CaptureSummary& summary, const std::filesystem::path& file) {
  fmt::print("{}: {:.1f} s, {:.1f} MB\n", file.string(), summary.last.elapsed_s,
             1e-6 * static_cast<double>(summary.last.file_bytes));
  fmt::print("{:<10} {:>12} {:>13} {:>15} {:>14}\n", "sensor", "body frames", "depth frames",
             "lost at source", "lost in queue");
  for (const SensorStatus& s : summary.last.sensors)
    fmt::print("{:<10} {:>12} {:>13} {:>15} {:>14}\n", s.name, s.body_frames, s.depth_frames,
               s.lost_at_source, s.lost_in_queue);
  if (summary.end == CaptureEnd::disk_full) fmt::print("ended because the disk is nearly full\n");
}

// Listens and waits until all agents are there.
std::unique_ptr<FrameSource> agents_of(const RecordArguments& arguments, LiveDisplay& display) {
  ListenOptions options;
  options.address = parse_address(arguments.listen);
  if (!arguments.keys.empty()) options.keys = read_tls_keys(arguments.keys);
  options.allow_plain_text = arguments.plain_text;
  options.compression = compression_named(arguments.compression);
  options.on_refusal = [&display](const std::string& refusal) { display.say(refusal); };
  auto source = std::make_unique<NetworkSource>(options);
  display.say(fmt::format("listening on port {}; waiting for {} agent{}", source->port(), arguments.agents,
                          arguments.agents == 1 ? "" : "s"));
  source->wait_for_agents(arguments.agents,
                          std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * arguments.wait_s)),
                          stop_requested);
  return source;
}

void refuse_full_disk(const std::filesystem::path& output, int reserve_mb) {
  const std::filesystem::path folder = std::filesystem::absolute(output).parent_path();
  const auto free_mb = static_cast<std::int64_t>(std::filesystem::space(folder).available >> 20);
  if (free_mb < reserve_mb)
    throw OutputError(
        folder.string(),
        fmt::format("has only {} MB left, and --reserve-mb is {}; four Kinects write some 1300 MB a minute",
                    free_mb, reserve_mb));
}

// Mark of the truth of this session, or of a recording that never began.
OutputMark truth_mark(const RecordArguments& arguments) {
  return {"record",
          {std::filesystem::weakly_canonical(std::filesystem::absolute(arguments.output)).string()}};
}

int record_session(const RecordArguments& arguments) {
  if (arguments.sources.empty() && arguments.listen.empty())
    throw InputError("--source", "is missing, and so is --listen; a source may be " + source_help());
  if (arguments.preview && ::isatty(STDERR_FILENO) != 1)
    throw InputError("--preview", "draws on a terminal, and stderr is none");
  if (!arguments.calibration.empty() && !arguments.preview)
    throw InputError("--calibration",
                     "is for --preview, which draws the person whom all sensors see together");
  const Calibration calibration =
      arguments.calibration.empty() ? Calibration{} : read_calibration(arguments.calibration);
  refuse_full_disk(arguments.output, arguments.reserve_mb);
  if (!arguments.truth.empty())
    check_output_folder({arguments.truth, {}, arguments.force}, truth_mark(arguments));
  const OutputClaim claim(arguments.output);
  check_output_file({arguments.output, {}, arguments.force});
  if (!arguments.truth.empty()) {
    write_truth(arguments.sources, arguments.truth, arguments.duration_s);
    mark_output(arguments.truth, truth_mark(arguments));
  }
  std::vector<std::unique_ptr<FrameSource>> sources;
  for (const std::string& text : arguments.sources) sources.push_back(open_source(text));
  LiveDisplay display;
  if (!arguments.listen.empty()) sources.push_back(agents_of(arguments, display));
  if (!arguments.truth.empty()) write_campaign_of(*sources.front(), arguments.output, arguments.truth);
  std::optional<SkeletonPreview> preview;
  if (arguments.preview && arguments.calibration.empty())
    preview.emplace(sources);
  else if (arguments.preview)
    preview.emplace(sources, calibration, arguments.calibration.string());
  CaptureOptions options;
  options.started_utc = utc_now();
  options.depth_compression = compression_named(arguments.compression);
  options.queue_bytes = static_cast<std::size_t>(arguments.queue_mb) << 20;
  options.workers = arguments.workers;
  options.reserve_bytes = static_cast<std::uint64_t>(arguments.reserve_mb) << 20;
  options.duration_s = arguments.duration_s;
  options.stop_requested = stop_requested;
  options.on_notice = [&](const std::string& sensor, const std::string& text) {
    display.say(sensor + ": " + text);
  };
  options.on_status = [&](const CaptureStatus& status) {
    display.show(status, preview ? preview->picture() : "");
  };
  if (preview)
    options.on_bodies = [&](const std::string& sensor, const BodyFrame& f) { preview->see(sensor, f); };
  const CaptureSummary summary = capture(sources, arguments.output, options);

  if (summary.end == CaptureEnd::disk_failed)
    throw OutputError(partial_name(arguments.output).string(),
                      "could not be written to its end (" + summary.problem +
                          "). What was flushed is in it: `trilat recover " +
                          partial_name(arguments.output).string() + "` makes it whole");
  if (arguments.json)
    fmt::print("{}\n", json_text(json_of(summary, arguments.output), 2));
  else
    print_summary(summary, arguments.output);
  const bool whole = !summary.lost_frames() && !summary.source_failed && summary.end != CaptureEnd::disk_full;
  return whole ? kDone : kItemsFailed;
}

}  // namespace

void add_record(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<RecordArguments>(app, code, "record",
                                             "sensors to a session; Ctrl-C ends it in order", record_session);
  verb.add_option("--source", a.sources, source_help() + "; may be repeated");
  auto* listen = verb.add_option("--listen", a.listen,
                                 "HOST:PORT where agents on other computers connect (`trilat-agent --help`)");
  verb.add_option("--agents", a.agents, "the recording begins when so many are there")
      ->check(CLI::Range(1, 64))
      ->needs(listen)
      ->capture_default_str();
  verb.add_option("--wait-s", a.wait_s, "how long to wait for them")
      ->check(CLI::PositiveNumber)
      ->needs(listen)
      ->capture_default_str();
  verb.add_option("--keys", a.keys, "recorder.keys, as made by `trilat-agent keys`")->needs(listen);
  verb.add_flag("--plain-text", a.plain_text, "without keys: let everybody on the way read and write")
      ->needs(listen);
  verb.add_option("-o,--output", a.output, "session.h5")->required();
  verb.add_option("--duration-s", a.duration_s, "ends after so long; 0: when somebody stops it")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb.add_option("--compression", a.compression,
                  "of depth: blosc (Zstandard, best; h5py needs hdf5plugin), deflate (any reader), none")
      ->check(CLI::IsMember({"blosc", "deflate", "none"}))
      ->capture_default_str();
  verb.add_option("--queue-mb", a.queue_mb, "memory for frames that wait for the disk; beyond, they are lost")
      ->check(CLI::Range(4, 1 << 16))
      ->capture_default_str();
  verb.add_option("--reserve-mb", a.reserve_mb, "the recording ends in order when the disk has less left")
      ->check(CLI::Range(0, 1 << 20))
      ->capture_default_str();
  verb.add_option("--workers", a.workers, "threads that compress")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  verb.add_flag("--preview", a.preview, "shows the skeletons on the terminal");
  verb.add_option("--calibration", a.calibration,
                  "with --preview: poses of the sensors; shows the person whom all see together, too");
  verb.add_option("--truth", a.truth,
                  "of a synthetic source: folder for the OptiTrack export, true poses and a campaign.json");
  add_force(verb, a.force);
  add_json(verb, a.json);
  verb.footer(
      "Examples:\n"
      "  trilat record --source synthetic:4 --duration-s 20 -o session.h5\n"
      "  trilat record --listen 0.0.0.0:7345 --agents 4 --keys keys/recorder.keys -o session.h5");
}

}  // namespace trilat
