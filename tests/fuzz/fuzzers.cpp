// SPDX-License-Identifier: MIT
#include "tests/fuzz/fuzzers.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/calibration/calibration.h"
#include "datasets/calibration/opencv_intrinsics.h"
#include "datasets/mocap/joint_csv.h"
#include "datasets/mocap/mocap_reader.h"
#include "datasets/mocap/mocap_summary.h"
#include "datasets/results/gate_history.h"
#include "datasets/results/results_file.h"
#include "datasets/results/stored_take.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_verify.h"
#include "datasets/synthetic/simulation_spec.h"
#include "datasets/take/campaign.h"
#include "pipeline/accuracy/methods/study_spec.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/claims/judge_claims.h"
#include "pipeline/gate/found_results.h"
#include "pipeline/recording/recording_study.h"
#include "pipeline/sweep/sweep_plan.h"
#include "pipeline/variations/variations_study.h"
#include "recorders/network/link/message_link.h"
#include "recorders/network/link/socket_address.h"
#include "recorders/network/link/tls_keys.h"
#include "recorders/network/link/tls_link.h"
#include "reports/chapter.h"
#include "reports/claims/claims.h"
#include "reports/figures/draw_figures.h"
#include "reports/provenance.h"
#include "reports/render/latex.h"
#include "reports/render/render.h"
#include "tests/fuzz/fuzz_folder.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/sound_results.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPlace = "fuzz.json";
constexpr std::uint64_t kSomeSamples = 256, kSomeBodies = 4096;

// Bad input may be refused; whatever else is thrown is a finding.
template <class Work>
void tolerate_bad_input(const Work& work) {
  try {
    work();
  } catch (const InputError&) {
  }
}

// A reader of a file as a fuzzer.
template <auto read_file_at>
void file(FuzzInput input) {
  const MemoryFile held(input);
  tolerate_bad_input([&] { (void)read_file_at(held.path()); });
}

// A reader of JSON as a fuzzer.
template <auto read_json>
void json(FuzzInput input) {
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  tolerate_bad_input([&] { read_json(parse_json(text, kPlace)); });
}

// ---- what a person writes
void read_study(const Json& json) {
  switch (study_kind(json, kPlace)) {
    case StudyKind::accuracy:
      resolved_json(parse_study(json, kPlace, {}));
      return;
    case StudyKind::threshold_sweep: {
      const SweepPlan plan = make_sweep_plan(parse_sweep(json, kPlace), kPlace);
      for (std::size_t cell = 0; cell < std::min<std::size_t>(plan.cells(), 64); ++cell)
        options_of(plan, place_of(plan, cell));
      return;
    }
    case StudyKind::calibration:
      resolved_json(parse_calibration_spec(json, kPlace));
      return;
    case StudyKind::recording:
      recording_parameters(parse_recording_spec(json, kPlace));
      return;
    case StudyKind::variations:
      resolved_json(parse_variations(json, kPlace, {}, Json::object()));
      return;
  }
}

void read_simulation(const Json& json) {
  rig_poses(parse_simulation(json, kPlace, {}).rig, Eigen::Vector3d::UnitY());
}

// ---- what other programs write
auto read_kinect_intrinsics(const fs::path& path) { return read_opencv_intrinsics(path, 512, 424); }

// A motion capture in any of its formats, as it is inspected and as ground truth.
void inspect_mocap(const fs::path& path) {
  MocapReader reader(path, {.block_bytes = 4096});
  summarize_mocap(reader);
}

void read_some_assets(const fs::path& path) {
  MocapReader reader(path, {.block_bytes = 64});
  std::vector<std::size_t> assets;
  for (std::size_t a = 0; a < reader.header().assets.size(); a += 2) assets.push_back(a);
  reader.read_only(assets);
  MocapFrame frame;
  while (reader.next(frame)) {
  }
}

void read_joints(const fs::path& path) {
  if (is_joint_csv(path)) read_joint_csv(path);
}

// ---- HDF5
void read_session(const fs::path& path) {
  const SessionReader session(path);
  verify_session(session, {});
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    session.body_frames(s, 0, std::min<std::uint64_t>(session.counts(s).body_frames, kSomeBodies));
    session.clock_exchanges(s);
    session.drop_counts(s);
    session.notices(s);
  }
}

void read_take(const fs::path& path) {
  const StoredTake take = StoredTake::open(path);
  for (std::size_t track = 0; track < take.head().tracks.size(); ++track)
    take.read(track, 0, std::min(kSomeSamples, take.head().instants), SampleColumns::all);
  take.read_errors();
  take.read_replay();
}

// ---- results: the first byte chooses one of the sound files, JSON in its place follows
void print(const Table& table) {
  markdown_of(table);
  csv_of(table);
  latex_of(table);
}

void report_on(const SoundFile& file) {
  if (file.name == "accepted.json") {
    read_beside<AcceptedBaseline>(file.folder);
  } else if (file.name == "history.jsonl") {
    read_history(file.folder / file.name);
  } else if (file.name == "simulator.json") {
    print(parameters_table(read_declared_parameters(file.folder), "fuzz"));
  } else {
    const Chapter chapter = read_chapter(file.folder, true);
    for (const Table& table : chapter.tables) print(table);
    for (const DrawnFigure& figure : chapter.figures) gnuplot_script(figure.figure);
    if (const auto paper = judge_paper({file.folder})) print(claims_table(*paper));
  }
}

void read_results_file(FuzzInput input) {
  static const FuzzFolder scratch("results");
  static const std::vector<SoundFile> files = sound_files(scratch.with_sound());
  if (input.empty()) return;
  const SoundFile& file = files[input[0] % files.size()];
  put(file.folder / file.name, {reinterpret_cast<const char*>(input.data()) + 1, input.size() - 1});
  tolerate_bad_input([&] { report_on(file); });
  tolerate_bad_input([&] { find_results(file.folder); });
  put(file.folder / file.name, file.text);
}

// ---- what a stranger may send to a machine that listens
void read_wire(FuzzInput input) {
  const std::span<const std::byte> bytes = std::as_bytes(input);
  (void)decode_message(bytes);
  MessageReader reader;
  reader.add(bytes);
  while (const auto message = reader.next()) {
    const auto* sound = std::get_if<Message>(&*message);
    if (sound) (void)encode_message(*sound);
  }
}

// A peer that says these bytes, whatever it hears, and goes.
class TalkingPeer : public ByteLink {
 public:
  explicit TalkingPeer(FuzzInput bytes) : left_(std::as_bytes(bytes)) {}
  std::size_t try_read(std::span<std::byte> into) override {
    if (left_.empty()) throw LinkLost("the peer has gone");
    const std::size_t count = std::min(into.size(), left_.size());
    std::copy_n(left_.begin(), count, into.begin());
    left_ = left_.subspan(count);
    return count;
  }
  std::size_t try_write(std::span<const std::byte> from) override { return from.size(); }
  void wait(bool, std::chrono::milliseconds) override {}
  void wake() override {}

 private:
  std::span<const std::byte> left_;
};

template <TlsSide side>
void shake_hands(FuzzInput input) {
  static const FuzzFolder folder("tls");
  static const auto made = make_tls_keys(folder.path(), {"k1", "k2"});
  static const TlsKeys keys =
      read_tls_keys(side == TlsSide::server ? folder.path() / "recorder.keys" : made[0]);
  try {
    const auto link = secure_link(std::make_unique<TalkingPeer>(input), keys, side, std::chrono::seconds(1));
    std::byte block[4096];
    while (link->try_read(block) > 0) {
    }
  } catch (const LinkLost&) {
  } catch (const LinkRefused&) {
  }
}

void read_address(FuzzInput input) {
  tolerate_bad_input([&] {
    const SocketAddress address = parse_address(std::string(input.begin(), input.end()));
    is_loopback(address);
    parse_address(text_of(address));
  });
}

constexpr Fuzzer kFuzzers[] = {
    {"study", json<read_study>},
    {"simulation", json<read_simulation>},
    {"campaign", file<read_campaign>},
    {"mapping", file<read_mapping>},
    {"calibration", file<[](const fs::path& path) { return calibration_json(read_calibration(path)); }>},
    {"intrinsics", file<read_kinect_intrinsics>},
    {"mocap_summary", file<inspect_mocap>},
    {"mocap", file<read_some_assets>},
    {"joint_csv", file<read_joints>},
    {"session", file<read_session>},
    {"take", file<read_take>},
    {"results", read_results_file},
    {"wire", read_wire},
    {"keys", file<read_tls_keys>},
    {"recorder_handshake", shake_hands<TlsSide::server>},
    {"agent_handshake", shake_hands<TlsSide::agent>},
    {"address", read_address},
};

}  // namespace

std::span<const Fuzzer> fuzzers() { return kFuzzers; }

void fuzz(std::string_view name, FuzzInput input) {
  const auto known = std::ranges::find(kFuzzers, name, &Fuzzer::name);
  if (known == std::end(kFuzzers)) {
    std::fprintf(stderr, "there is no fuzzer \"%s\"; there are:", std::string(name).c_str());
    for (const Fuzzer& fuzzer : kFuzzers) std::fprintf(stderr, " %s", std::string(fuzzer.name).c_str());
    std::fprintf(stderr, "\n");
    std::exit(2);
  }
  known->read(input);
}

}  // namespace trilat

// HDF5 itself forgets some memory when a file's metadata are damaged.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5\n"; }
