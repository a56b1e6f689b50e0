// SPDX-License-Identifier: MIT
// Records in a second process, kills it at a random instant or lets its disk run full, recovers, and compares
// every frame that was in the log's file with what was recorded, byte for byte.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/philox.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/write_session.h"
#include "recorders/capture.h"
#include "tests/recorders/link_torture.h"
#include "tests/recorders/pattern_source.h"

namespace trilat {
namespace {

constexpr std::size_t kSensors = 2;
constexpr std::int64_t kFrames = 60;

// What one trial is to do. In the recording process `says` gets how many bytes of the log are in its file.
struct Trial {
  std::filesystem::path session;
  double kill_after_s = -1.0;
  rlim_t file_limit_bytes = RLIM_INFINITY;
};

// A source that keeps to a rhythm, so that a recording lasts long enough to be killed in.
class SteadySource : public PatternSource {
 public:
  SteadySource() : PatternSource(kSensors, kFrames) {}
  std::optional<SourceEvent> next() override {
    std::this_thread::sleep_for(std::chrono::microseconds(400));
    return PatternSource::next();
  }
};

[[noreturn]] void record_and_exit(const Trial& trial, int says) {
  if (trial.file_limit_bytes != RLIM_INFINITY) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{trial.file_limit_bytes, trial.file_limit_bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  CaptureOptions options;
  options.look_period_s = 0.01;
  options.reserve_bytes = 0;
  options.on_status = [&](const CaptureStatus& status) {
    if (::write(says, &status.log_bytes, sizeof status.log_bytes) != sizeof status.log_bytes) std::_Exit(3);
  };
  std::vector<std::unique_ptr<FrameSource>> sources;
  sources.push_back(std::make_unique<SteadySource>());
  try {
    const CaptureSummary summary = capture(sources, trial.session, options);
    std::exit(summary.end == CaptureEnd::source_ended && summary.log_left.empty() ? 0 : 4);
  } catch (const OutputError&) {
    std::exit(1);
  } catch (const InputError&) {
    std::exit(2);
  }
}

std::uint64_t last_of(int pipe) {
  std::uint64_t safe = 0, next = 0;
  while (::read(pipe, &next, sizeof next) == sizeof next) safe = next;
  return safe;
}

// Empty when the session holds nothing but what was recorded, without a gap.
std::string difference(const SessionReader& session) {
  std::vector<std::uint16_t> depth(kDepthPixels);
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    const SensorCounts& counts = session.counts(s);
    const auto bodies = session.body_frames(s, 0, counts.body_frames);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const BodyFrame expected = PatternSource::bodies_of(s, static_cast<std::int64_t>(i));
      bool same = bodies[i].stamp.arrival_ns == expected.stamp.arrival_ns &&
                  bodies[i].floor_plane == expected.floor_plane &&
                  bodies[i].bodies.size() == expected.bodies.size();
      for (std::size_t b = 0; same && b < expected.bodies.size(); ++b)
        same = bodies[i].bodies[b].position_m == expected.bodies[b].position_m &&
               bodies[i].bodies[b].tracking_id == expected.bodies[b].tracking_id &&
               bodies[i].bodies[b].tracking_state == expected.bodies[b].tracking_state;
      if (!same) return fmt::format("body frame {} of sensor {} is another", i, s);
    }
    const auto stamps = session.stamps(s, FrameStream::depth, 0, counts.depth_frames);
    for (std::size_t i = 0; i < stamps.size(); ++i) {
      session.depth_frame(s, i, depth);
      if (stamps[i].sequence != static_cast<std::int64_t>(i) ||
          depth != PatternSource::depth_of(s, static_cast<std::int64_t>(i)))
        return fmt::format("depth frame {} of sensor {} is another", i, s);
    }
    const auto exchanges = session.clock_exchanges(s);
    for (std::size_t i = 0; i < exchanges.size(); ++i)
      if (exchanges[i].t4_ns != static_cast<std::int64_t>(i) + 3)
        return fmt::format("clock exchange {} of sensor {} is another", i, s);
  }
  return "";
}

struct ItemResult {
  std::string problem;  // empty: nothing was lost
  bool complete = false, nothing_written = false;
};

// A log that its process left becomes a session first. `safe`: bytes that were in its file.
ItemResult examine(const Trial& trial, std::uint64_t safe) {
  ItemResult outcome;
  outcome.nothing_written = safe == 0;
  const std::filesystem::path log = log_name(trial.session);
  try {
    outcome.complete = !std::filesystem::exists(log);
    std::filesystem::path readable = trial.session;
    if (!outcome.complete) {
      readable = trial.session.string() + ".saved.h5";
      const LogsWritten written = write_session({{log}}, readable);
      if (written.logs[0].end < safe || written.logs[0].gap_count > 0)
        outcome.problem = fmt::format("{} bytes are whole, {} were in the file, {} places are damaged",
                                      written.logs[0].end, safe, written.logs[0].gap_count);
    }
    const SessionReader session(readable);
    if (!session.complete()) outcome.problem = "is not complete";
    if (outcome.problem.empty()) outcome.problem = difference(session);
  } catch (const InputError& error) {
    if (!outcome.nothing_written) outcome.problem = error.what();  // there may be no file, or no head in it
  }
  return outcome;
}

// Records in a process of its own; what was safe when it ended, and how it should not have ended.
std::pair<std::uint64_t, std::string> record_apart(const Trial& trial) {
  int ends[2];
  if (::pipe(ends) != 0) return {0, "no pipe"};
  const pid_t child = fork();
  if (child == 0) {
    ::close(ends[0]);
    record_and_exit(trial, ends[1]);
  }
  ::close(ends[1]);
  if (trial.kill_after_s >= 0.0) {
    std::this_thread::sleep_for(std::chrono::duration<double>(trial.kill_after_s));
    kill(child, SIGKILL);
  }
  const std::uint64_t safe = last_of(ends[0]);
  ::close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  const bool killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL && trial.kill_after_s >= 0.0;
  if (!killed && !(WIFEXITED(status) && WEXITSTATUS(status) <= 1))
    return {safe, fmt::format("the recording process ended with status {}", status)};
  return {safe, ""};
}

ItemResult run(const Trial& trial) {
  const auto [safe, problem] = record_apart(trial);
  return problem.empty() ? examine(trial, safe) : ItemResult{problem, false, false};
}

void remove_files(const Trial& trial) {
  for (const char* tail : {"", ".partial", ".trilog", ".saved.h5"})
    std::filesystem::remove(trial.session.string() + tail);
}

double seconds_of_a_whole_recording(const std::filesystem::path& folder) {
  const Trial trial{folder / "whole.h5"};
  remove_files(trial);
  const auto start = std::chrono::steady_clock::now();
  const auto [safe, problem] = record_apart(trial);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const ItemResult outcome = examine(trial, safe);
  if (!problem.empty() || !outcome.problem.empty() || !outcome.complete)
    throw InputError("an undisturbed recording", problem + outcome.problem);
  return seconds;
}

int torture(int kills, int full_disks, std::uint64_t seed, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const double whole_s = seconds_of_a_whole_recording(folder);
  const auto whole_bytes = std::filesystem::file_size(folder / "whole.h5");
  const RandomStream random{seed, Purpose::sensor_drop, 0};
  int lost = 0, complete = 0, empty = 0;
  for (int i = 0; i < kills + full_disks; ++i) {
    const double draw = random.uniform(static_cast<std::uint32_t>(i));
    Trial trial{folder / fmt::format("trial_{}.h5", i)};
    if (i < kills)
      trial.kill_after_s = draw * whole_s;
    else
      trial.file_limit_bytes = static_cast<rlim_t>(draw * static_cast<double>(whole_bytes));
    remove_files(trial);  // an earlier torture was killed itself
    const ItemResult outcome = run(trial);
    complete += outcome.complete;
    empty += outcome.nothing_written;
    if (!outcome.problem.empty()) {
      ++lost;
      fmt::print(stderr, "trial {} ({}): {}\n", i,
                 i < kills ? fmt::format("killed after {:.4f} s", trial.kill_after_s)
                           : fmt::format("disk full at {} bytes", trial.file_limit_bytes),
                 outcome.problem);
    } else {
      remove_files(trial);
    }
  }
  fmt::print(
      "{} kills, {} full disks; a whole recording takes {:.3f} s: {} logs lost anything that was in their "
      "files; "
      "{} had become sessions before, {} had written nothing yet\n",
      kills, full_disks, whole_s, lost, complete, empty);
  return lost == 0 ? 0 : 1;
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  CLI::App app(
      "Kills recorders and agents, lets disks run full, breaks links, spoils logs, and sees what is left");
  int kills = 300, full_disks = 50, link_kills = 300, outages = 200, logs = 10000;
  double longest_s = 60.0;
  std::uint64_t seed = 1;
  std::string folder = (std::filesystem::temp_directory_path() / "trilat_torture").string();
  app.add_option("--kills", kills, "of a recorder of local sensors")->capture_default_str();
  app.add_option("--full-disks", full_disks)->capture_default_str();
  app.add_option("--link-kills", link_kills, "of recorder, agent or both")->capture_default_str();
  app.add_option("--outages", outages, "of the link")->capture_default_str();
  app.add_option("--longest-s", longest_s, "of an outage")->capture_default_str();
  app.add_option("--logs", logs, "that are cut or flipped")->capture_default_str();
  app.add_option("--seed", seed)->capture_default_str();
  app.add_option("--folder", folder)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::signal(SIGPIPE, SIG_IGN);
  std::filesystem::create_directories(folder);
  int failed = kills + full_disks > 0 ? trilat::torture(kills, full_disks, seed, folder) : 0;
  failed += trilat::torture_with_kills(link_kills, seed, folder);
  failed += trilat::torture_with_outages(outages, longest_s, seed, folder);
  failed += trilat::torture_logs(logs, seed, folder);
  return failed == 0 ? 0 : 1;
}
