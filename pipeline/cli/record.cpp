// SPDX-License-Identifier: MIT
// `trilat record`.
#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/words.h"
#include "datasets/rig/calibration.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/skeleton_preview.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/simulate/simulate_take.h"
#include "recorders/capture.h"
#include "recorders/frame_source.h"
#include "recorders/link/byte_stream.h"
#include "recorders/open_source.h"

namespace trilat {
namespace {

struct RecordArguments {
  std::vector<std::string> sources;
  std::string listen;  // HOST:PORT, or empty
  std::size_t agents = 0;
  double wait_s = 60.0;
  std::filesystem::path output;
  double duration_s = 0.0;
  bool preview = false;
  std::filesystem::path calibration;
  std::filesystem::path truth;
  bool force = false;  // may replace what others wrote
  bool json = false;
};

// Status of a running recording on stderr: a line over itself on a terminal, now and then elsewhere, with
// notices above it. A terminal that takes nothing holds up this thread, not the recording.
class LiveDisplay {
 public:
  // `picture` is drawn over the whole screen first.
  void show(const CaptureStatus& status, const std::string& picture = {});
  void say(const std::string& text);

 private:
  std::mutex mutex_;  // agents are refused by other threads
  const bool terminal_ = ::isatty(STDERR_FILENO) == 1;
  std::deque<std::string> below_picture_;
  double next_s_ = 0.0;
};

// The line itself.
std::string status_line(const CaptureStatus& status) {
  const double written =
      status.elapsed_s > 0.0 ? static_cast<double>(status.log_bytes) / status.elapsed_s : 0.0;
  std::string line = fmt::format("{:4.0f} s ", status.elapsed_s);
  std::int64_t lost = 0;
  for (const SensorStatus& s : status.sensors) {
    line += fmt::format(" {} {:.1f} Hz", s.name, s.rate_hz);
    lost += s.lost_at_source + s.lost_in_queue;
  }
  line += fmt::format("  lost {}  {:.0f} MB wait  {:.1f} MB/s  {:.1f} GB free", lost,
                      1e-6 * static_cast<double>(status.waiting_bytes), 1e-6 * written,
                      1e-9 * static_cast<double>(status.disk_free_bytes));
  if (written > 0.0)  // the session needs as much again
    line += fmt::format(" ({:.0f} min)", 0.5 * static_cast<double>(status.disk_free_bytes) / written / 60.0);
  return line;
}

void LiveDisplay::show(const CaptureStatus& status, const std::string& picture) {
  constexpr double kLinePeriod_s = 10.0;  // where lines stay
  const std::lock_guard lock(mutex_);
  if (!terminal_ && status.elapsed_s < next_s_) return;
  next_s_ = status.elapsed_s + kLinePeriod_s;
  std::string out = picture;
  if (!picture.empty())
    for (const std::string& text : below_picture_) out += text + "\n";
  out += (terminal_ ? "\r\033[K" : "") + status_line(status) + (terminal_ ? "" : "\n");
  std::fputs(out.c_str(), stderr);  // a failure here cannot be reported
}

void LiveDisplay::say(const std::string& text) {
  constexpr std::size_t kMaxBelow = 4;
  const std::lock_guard lock(mutex_);
  below_picture_.push_back(text);
  if (below_picture_.size() > kMaxBelow) below_picture_.pop_front();
  std::fputs(((terminal_ ? "\r\033[K" : "") + text + "\n").c_str(), stderr);
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

// Both clocks at once, so that somebody can tell later when the host clock's times were.
std::string utc_now() {
  const auto now = std::chrono::system_clock::now();
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}Z at host clock {} ns",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(now)), host_now_ns());
}

const char* name_of(CaptureEnd end) {
  constexpr std::array kNames{"source_ended", "stop_requested", "duration_over", "disk_full"};
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
          {"file_bytes", summary.session_bytes},
          {"log_left", summary.log_left.empty() ? Json() : Json(log_name(file).string())},
          {"source_failed", summary.source_failed},
          {"sensors", sensors}};
}

void print_summary(const CaptureSummary& summary, const std::filesystem::path& file) {
  fmt::print("{}: {:.1f} s, {:.1f} MB\n", file.string(), summary.last.elapsed_s,
             1e-6 * static_cast<double>(summary.session_bytes));
  fmt::print("{:<10} {:>12} {:>13} {:>15} {:>14}\n", "sensor", "body frames", "depth frames",
             "lost at source", "lost in queue");
  for (const SensorStatus& s : summary.last.sensors)
    fmt::print("{:<10} {:>12} {:>13} {:>15} {:>14}\n", s.name, s.body_frames, s.depth_frames,
               s.lost_at_source, s.lost_in_queue);
  if (summary.end == CaptureEnd::disk_full) fmt::print("ended because the disk is nearly full\n");
}

// Listener for agents: this user's socket, which `trilat receive` leads to, or a port of this machine.
std::unique_ptr<StreamListener> listener_of(const RecordArguments& arguments, LiveDisplay& display) {
  auto listener = arguments.listen.empty()
                      ? std::make_unique<StreamListener>(receive_sockets().front())
                      : std::make_unique<StreamListener>(parse_address(arguments.listen));
  display.say(fmt::format("{}; waiting for {}",
                          arguments.listen.empty() ? "taking what `trilat receive` brings"
                                                   : fmt::format("listening on port {}", listener->port()),
                          counted(arguments.agents, "agent")));
  return listener;
}

// For how long there is room; OutputError where there is none.
std::string room_for(const std::filesystem::path& output) {
  constexpr double kFourKinects_MB_min = 1300.0;  // compressed
  const std::filesystem::path folder = std::filesystem::absolute(output).parent_path();
  const std::uint64_t free = std::filesystem::space(folder).available;
  if (free < CaptureOptions::kDiskReserve_bytes)
    throw OutputError(folder.string(),
                      fmt::format("has only {} MB left; a recording needs {} MB and more, and four Kinects "
                                  "write {:.0f} MB a minute, twice while the session is made of the log",
                                  free >> 20, CaptureOptions::kDiskReserve_bytes >> 20, kFourKinects_MB_min));
  return fmt::format(
      "{:.1f} GB free, of which log and session share half each: {:.0f} minutes of four Kinects",
      1e-9 * static_cast<double>(free), 0.5e-6 * static_cast<double>(free) / kFourKinects_MB_min);
}

// Output mark of the folder of --truth, of this session or of a recording that never began.
OutputMark truth_mark(const RecordArguments& arguments) {
  return {"record",
          {std::filesystem::weakly_canonical(std::filesystem::absolute(arguments.output)).string()}};
}

void check_record(const RecordArguments& arguments) {
  if (arguments.sources.empty() && arguments.agents == 0)
    throw InputError("--source", "is missing, and so is --agents; a source may be " + source_help());
  if (arguments.preview && ::isatty(STDERR_FILENO) != 1)
    throw InputError("--preview", "draws on a terminal, and stderr is none");
  if (!arguments.calibration.empty() && !arguments.preview)
    throw InputError("--calibration",
                     "is for --preview, which draws the person whom all sensors see together");
  if (!arguments.truth.empty())
    check_output_folder({arguments.truth, {}, arguments.force}, truth_mark(arguments));
  check_output_file({arguments.output, {}, arguments.force});
}

// Opens the sources, and writes what --truth asks for.
std::vector<std::unique_ptr<FrameSource>> open_sources(const RecordArguments& arguments) {
  const bool has_truth = !arguments.truth.empty();
  if (has_truth) {
    write_truth(arguments.sources, arguments.truth, arguments.duration_s);
    mark_output(arguments.truth, truth_mark(arguments));
  }
  std::vector<std::unique_ptr<FrameSource>> sources;
  for (const std::string& text : arguments.sources) sources.push_back(open_source(text));
  if (has_truth) write_campaign_of(*sources.front(), arguments.output, arguments.truth);
  return sources;
}

int end_of(const CaptureSummary& summary, const RecordArguments& arguments) {
  if (arguments.json)
    fmt::print("{}\n", json_text(json_of(summary, arguments.output), 2));
  else
    print_summary(summary, arguments.output);
  if (!summary.log_left.empty())
    fmt::print(stderr, "failed: {}; the log stays for a closer look: {}\n", summary.log_left,
               log_name(arguments.output).string());
  const bool whole = !summary.lost_frames() && !summary.source_failed &&
                     summary.end != CaptureEnd::disk_full && summary.log_left.empty();
  return whole ? kDone : kItemsFailed;
}

int record_session(const RecordArguments& arguments) {
  std::signal(SIGPIPE, SIG_IGN);  // whoever reads what is shown may go
  check_record(arguments);
  const Calibration calibration =
      arguments.calibration.empty() ? Calibration{} : read_calibration(arguments.calibration);
  std::string room = room_for(arguments.output);
  std::vector<std::unique_ptr<FrameSource>> sources = open_sources(arguments);
  LiveDisplay display;
  std::optional<SkeletonPreview> preview;
  if (arguments.preview && arguments.calibration.empty())
    preview.emplace();
  else if (arguments.preview)
    preview.emplace(calibration, arguments.calibration.string());
  CaptureOptions options;
  options.started_utc = utc_now();
  options.duration_s = arguments.duration_s;
  options.agents = arguments.agents;
  options.listen = [&] { return listener_of(arguments, display); };
  options.wait_s = arguments.wait_s;
  options.stop_requested = stop_requested;
  options.on_notice = [&](const std::string& text) { display.say(text); };
  options.on_status = [&](const CaptureStatus& status) {
    if (!room.empty()) display.say(std::exchange(room, {}));
    if (preview)
      for (const SensorStatus& sensor : status.sensors)
        if (sensor.newest_bodies) preview->see(sensor.name, sensor.intrinsics, *sensor.newest_bodies);
    display.show(status, preview ? preview->picture() : "");
  };
  std::optional<Progress> progress;
  options.on_writing = [&](double share) {
    if (!progress) progress.emplace("writing and verifying " + arguments.output.filename().string());
    progress->set(share);
    return true;
  };
  const CaptureSummary summary = capture(sources, arguments.output, options);
  progress.reset();
  return end_of(summary, arguments);
}

}  // namespace

void add_record(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<RecordArguments>(app, code, "record",
                                             "sensors to a session; Ctrl-C ends it in order", record_session);
  verb.add_option("--source", a.sources, source_help() + "; may be repeated");
  verb.add_option("--agents", a.agents,
                  "how many other computers send a sensor: `trilat-agent run --recorder USER@HOST` there")
      ->check(CLI::Range(1, 64));
  verb.add_option("--listen", a.listen,
                  "127.0.0.1:PORT where agents connect, as a tunnel's end, in place of SSH")
      ->each([&a](const std::string&) { a.agents = std::max<std::size_t>(a.agents, 1); });
  verb.add_option("--wait-s", a.wait_s, "how long to wait for them")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  for (const char* option : {"--keys", "--plain-text"})
    removed_option(verb, option,
                   "agents reach this recorder through SSH (`trilat-agent run --recorder USER@HOST`)");
  verb.add_option("-o,--output", a.output, "session.h5")->required();
  verb.add_option("--duration-s", a.duration_s, "ends after so long; 0: when somebody stops it")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  removed_option(verb, "--compression", "depth is stored by Blosc, which h5py reads with hdf5plugin");
  for (const char* option : {"--queue-mb", "--reserve-mb", "--workers"})
    removed_option(verb, option, "a recording takes what memory and threads it needs; leave it out");
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
      "  trilat record --agents 4 -o session.h5");
}

namespace {

struct ReceiveArguments {};

// Between standard input and output, as SSH carries them, and the recorder of this user.
int receive(const ReceiveArguments&) {
  std::signal(SIGPIPE, SIG_IGN);
  std::string problem;
  for (const std::filesystem::path& path : receive_sockets()) try {
      const auto recorder = connect_local(path), agent = standard_stream();
      join_streams(*agent, *recorder);
      return kDone;
    } catch (const LinkLost& lost) {
      problem = lost.what();
    }
  throw InputError(
      "trilat receive",
      "finds no recorder of this user that waits for agents (`trilat record --agents N`): " + problem);
}

}  // namespace

void add_receive(CLI::App& app, int& code) {
  add_verb<ReceiveArguments>(
      app, code, "receive",
      "carry an agent's bytes, on standard input and output, to the recorder of this user; for SSH", receive,
      OnInterrupt::at_once);
}

}  // namespace trilat
