// SPDX-License-Identifier: MIT
// `trilat record` and `recover`, as a user runs them.
#include <chrono>
#include <cstdlib>
#include <thread>

#include <gmock/gmock.h>

#include "datasets/rig/campaign.h"
#include "datasets/rig/rigid_transform.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_writer.h"
#include "pipeline/cli/skeleton_preview.h"
#include "tests/datasets/made_session.h"
#include "tests/pipeline/program.h"
#include "tests/support/paths.h"

namespace trilat {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

std::string in(const ScratchFolder& folder, const std::string& name) { return (folder / name).string(); }

void wait_for(const std::function<bool()>& condition) {
  for (int i = 0; i < 1200 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_TRUE(condition());
}

TEST(Record, WritesASessionAndSaysWhatIsInIt) {
  const ScratchFolder folder;
  const Ended ended = run_trilat(folder, {"record", "--source", "synthetic:2,duration=0.5,speed=max", "-o",
                                          in(folder, "s.h5"), "--json"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  const Json json = only_json(ended);
  EXPECT_EQ(json["end"], "source_ended");
  ASSERT_EQ(json["sensors"].size(), 2u);
  const SessionReader session(folder / "s.h5");
  EXPECT_TRUE(session.complete());
  for (std::size_t s = 0; s < 2; ++s) {
    EXPECT_EQ(session.counts(s).depth_frames, 15u);
    EXPECT_EQ(session.counts(s).body_frames, 15u);
    EXPECT_EQ(json["sensors"][s]["depth_frames"], 15);
  }
}

TEST(Record, EndsWhenItsDurationIsOver) {
  const ScratchFolder folder;
  const Ended ended = run_trilat(folder, {"record", "--source", "synthetic:2,depth=no", "--duration-s", "1",
                                          "-o", in(folder, "s.h5"), "--json"});
  EXPECT_EQ(only_json(ended)["end"], "duration_over") << ended.err;
  const SessionReader session(folder / "s.h5");
  EXPECT_TRUE(session.complete());
  EXPECT_GT(session.counts(0).body_frames, 0u);
  EXPECT_LE(session.counts(0).body_frames, 35u);
  EXPECT_THAT(session.header().started_utc, HasSubstr("at host clock"));
}

TEST(Record, InterruptedClosesTheFileInOrder) {
  const ScratchFolder folder;
  const Process process(folder, {"record", "--source", "synthetic:1,depth=no", "-o", in(folder, "s.h5")});
  wait_for([&] { return std::filesystem::exists(in(folder, "s.h5.trilog")); });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  process.interrupt();
  EXPECT_EQ(process.wait().code, 0);
  EXPECT_TRUE(SessionReader(folder / "s.h5").complete());
}

TEST(Record, AKilledRecordingIsRecoveredAndEvaluated) {
  const ScratchFolder folder;
  const Process process(folder, {"record", "--source", "synthetic:4,depth=no", "--truth", in(folder, "truth"),
                                 "-o", in(folder, "s.h5")});
  // a slow machine takes its time until so many frames are there
  Json followed;
  wait_for([&] {
    const Ended info = run_trilat(folder, {"info", in(folder, "s.h5"), "--json"});
    if (info.code != 0) return false;  // not there yet
    followed = only_json(info);
    return followed["sensors"][0]["body_frames"].get<int>() > 60;
  });
  EXPECT_EQ(followed["recording"], true);
  expect_refused(run_trilat(folder, {"recover", in(folder, "s.h5.trilog")}),
                 "is being written by a recording that still runs");
  process.kill_at_once();
  EXPECT_EQ(process.wait().code, -1);
  EXPECT_THAT(run_trilat(folder, {"info", in(folder, "s.h5")}).out, HasSubstr("NOT ended by its recorder"));
  expect_refused(run_trilat(folder, {"verify", in(folder, "s.h5")}), "did not become a session yet");
  expect_refused(run_trilat(folder, {"record", "--source", "synthetic:1,depth=no", "-o", in(folder, "s.h5")}),
                 "of a recorder that was killed");
  const Ended recovered = run_trilat(folder, {"recover", in(folder, "s.h5"), "--json"});
  EXPECT_EQ(recovered.code, 0) << recovered.err;
  const Json json = only_json(recovered);
  EXPECT_THAT(json["session"].get<std::string>(), EndsWith("s.h5"));
  EXPECT_GT(json["sensors"][0]["body_frames"].get<int>(), 60);
  EXPECT_TRUE(SessionReader(folder / "s.h5").complete());
  EXPECT_TRUE(std::filesystem::exists(in(folder, "s.h5.trilog")));
  const std::string study = file_with(folder, "study.json", R"({"format": "trilat.study", "version": 1,
      "kind": "accuracy", "name": "mine", "alignments": ["none"], "methods": [{"method": "mean"}]})");
  const std::vector<std::string> run{
      "run", study, "--campaign", in(folder, "truth"), "-o", in(folder, "results"), "--json"};
  const Ended ran = run_trilat(folder, run);
  EXPECT_EQ(ran.code, 0) << ran.err;
}

// The port that a listening recorder says it has.
std::string port_of(const ScratchFolder& folder) {
  const std::string begin = "listening on port ";
  std::string port;
  wait_for([&] {
    if (!std::filesystem::exists(folder / "record_stderr.txt")) return false;
    const std::string said = read_file(folder / "record_stderr.txt");
    const std::size_t at = said.find(begin);
    if (at == std::string::npos || said.find(';', at) == std::string::npos) return false;
    port = said.substr(at + begin.size(), said.find(';', at) - at - begin.size());
    return true;
  });
  return port;
}

Process agent_of(const ScratchFolder& folder, const std::string& name, const std::vector<std::string>& more) {
  std::vector<std::string> words{"run", "--name", name, "--folder", folder.path().string()};
  words.insert(words.end(), more.begin(), more.end());
  return Process(folder, words, name + "_", kAgentProgram);
}

const std::string kSomeSource = "synthetic:1,depth=no,duration=2";  // rendered depth would be late

TEST(Record, SensorsOfTwoComputersBecomeOneSession) {
  const ScratchFolder folder;
  const Process record(
      folder, {"record", "--listen", "127.0.0.1:0", "--agents", "2", "-o", in(folder, "s.h5"), "--json"},
      "record_");
  const std::string recorder = "127.0.0.1:" + port_of(folder);
  const Process left = agent_of(folder, "left", {"--recorder", recorder, "--source", kSomeSource});
  const Process right = agent_of(folder, "right", {"--recorder", recorder, "--source", kSomeSource});
  EXPECT_EQ(left.wait().code, 0);
  EXPECT_EQ(right.wait().code, 0);
  const Ended ended = record.wait();
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(only_json(ended)["end"], "source_ended");
  const SessionReader session(folder / "s.h5");
  ASSERT_EQ(session.header().sensors.size(), 2u);
  EXPECT_TRUE(session.header().simulated);
  EXPECT_EQ(session.header().sensors[0].name, "left");
  EXPECT_EQ(session.header().sensors[1].name, "right");
  for (std::size_t s = 0; s < 2; ++s) {
    EXPECT_EQ(session.counts(s).body_frames, 60u);
    EXPECT_GE(session.counts(s).clock_exchanges, 4u);
  }
}

// As SSH reaches it: a program whose standard input and output lead to `trilat receive`.
TEST(Record, AgentsReachTheRecorderThroughAnyProgram) {
  const ScratchFolder folder;
  const std::string environment = "XDG_RUNTIME_DIR=" + folder.path().string();
  const std::string record = environment + " " + kProgram + " record --agents 1 -o " + in(folder, "s.h5") +
                             " 2>" + in(folder, "record.txt") + " >/dev/null &";
  ASSERT_EQ(std::system(record.c_str()), 0);
  const Process agent =
      agent_of(folder, "k2", {"--via", environment + " " + kProgram + " receive", "--source", kSomeSource});
  const Ended ended = agent.wait();
  EXPECT_EQ(ended.code, 0) << ended.err;
  wait_for([&] {
    return std::filesystem::exists(folder / "s.h5") && !std::filesystem::exists(folder / "s.h5.trilog");
  });
  const SessionReader session(folder / "s.h5");
  EXPECT_EQ(session.header().sensors.at(0).name, "k2");
  EXPECT_EQ(session.counts(0).body_frames, 60u);
  EXPECT_EQ(std::filesystem::status(folder / "trilat").permissions(), std::filesystem::perms::owner_all);
}

TEST(Record, ARecorderThatIsKilledGoesOnWithTheSameLineAndLosesNothingOfItsAgents) {
  const ScratchFolder folder;
  const std::string port = "127.0.0.1:" + std::to_string(20000 + getpid() % 6000);
  const std::vector<std::string> line{"record", "--listen",         port,    "--agents", "1",
                                      "-o",     in(folder, "s.h5"), "--json"};
  const Process first(folder, line, "first_");
  const Process agent =
      agent_of(folder, "k1", {"--recorder", port, "--source", "synthetic:1,depth=no,duration=4"});
  wait_for([&] {
    std::uintmax_t bytes = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
      if (entry.path().filename().string().starts_with("s.h5.k1.")) bytes = entry.file_size();
    return bytes > 20'000;
  });
  first.kill_at_once();
  first.wait();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const Process second(folder, line, "second_");
  EXPECT_EQ(agent.wait().code, 0);
  const Ended ended = second.wait();
  EXPECT_EQ(ended.code, 0) << ended.err;
  const SessionReader session(folder / "s.h5");
  ASSERT_EQ(session.counts(0).body_frames, 120u);
  const auto stamps = session.stamps(0, FrameStream::bodies, 0, 120);
  for (std::size_t i = 0; i < stamps.size(); ++i) EXPECT_EQ(stamps[i].sequence, static_cast<std::int64_t>(i));
  EXPECT_EQ(only_json(ended)["sensors"][0]["lost_at_source"], 0);
}

TEST(Record, AfterAKilledRecorderAnotherRecordingLeavesTheFirstOneOnTheAgentsDisk) {
  const ScratchFolder folder;
  const std::string port = "127.0.0.1:" + std::to_string(26000 + getpid() % 6000);
  const auto record = [&](const std::string& name) {
    return std::vector<std::string>{"record", "--listen",       port,    "--agents", "1",
                                    "-o",     in(folder, name), "--json"};
  };
  const Process first(folder, record("a.h5"), "first_");
  const Process agent =
      agent_of(folder, "k1", {"--recorder", port, "--source", "synthetic:1,depth=no,duration=8"});
  const auto copy_bytes = [&] {
    std::uintmax_t bytes = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
      if (entry.path().filename().string().starts_with("a.h5.k1.")) bytes = entry.file_size();
    return bytes;
  };
  wait_for([&] { return copy_bytes() > 20'000; });
  first.kill_at_once();
  first.wait();
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  const Process second(folder, record("b.h5"), "second_");
  const Ended sent = agent.wait();
  EXPECT_EQ(sent.code, 1) << sent.err;
  EXPECT_THAT(sent.err, HasSubstr("another recording has begun; what the one before did not take lies in "));
  second.wait();
  std::string left;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    if (entry.path().filename().string().starts_with("k1.")) left = entry.path().string();
  EXPECT_THAT(sent.err,
              HasSubstr(std::filesystem::path(left).filename().string() + " OTHER.trilog... -o session.h5"));
  expect_refused(run_trilat(folder, {"recover", in(folder, "a.h5"), left, "-o", in(folder, "c.h5")}),
                 "is the same log as");
  const Ended joined =
      run_trilat(folder, {"recover", in(folder, "a.h5.trilog"), left, "-o", in(folder, "a.h5")});
  EXPECT_EQ(joined.code, 0) << joined.err;
  const SessionReader a(folder / "a.h5"), b(folder / "b.h5");
  EXPECT_EQ(a.counts(0).body_frames + b.counts(0).body_frames, 240u);
  EXPECT_GT(b.counts(0).body_frames, 20u);
}

TEST(Record, AClosedTerminalEndsItInOrder) {
  const ScratchFolder folder;
  const Process process(folder, {"record", "--source", "synthetic:1,depth=no", "-o", in(folder, "s.h5")});
  wait_for([&] { return std::filesystem::exists(in(folder, "s.h5.trilog")); });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  process.hang_up();
  EXPECT_EQ(process.wait().code, 0);
  EXPECT_TRUE(SessionReader(folder / "s.h5").complete());
}

TEST(Recover, SavesWhatARecorderOfVersion04Left) {
  const ScratchFolder folder;
  SessionWriter writer(folder / "s.h5", header_of(1));
  for (std::int64_t i = 0; i < 8; ++i) writer.add_body_frame(0, body_frame_of(i, 1));
  writer.finish();
  const auto partial = killed_by_0_4(folder / "s.h5", 7, 0);
  const std::string before = read_file(partial);
  const Ended ended = run_trilat(folder, {"recover", in(folder, "s.h5"), "--json"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  const Json json = only_json(ended);
  EXPECT_EQ(json["sensors"][0]["body_frames"], 7);
  EXPECT_EQ(json["session"], in(folder, "s.h5"));
  EXPECT_EQ(json["from"], partial.string());
  EXPECT_EQ(SessionReader(folder / "s.h5").counts(0).body_frames, 7u);
  EXPECT_EQ(read_file(partial), before);
}

TEST(Recover, AFinishedRecordingWithoutItsNameGetsIt) {
  const ScratchFolder folder;
  run_trilat(folder,
             {"record", "--source", "synthetic:1,depth=no,duration=0.5,speed=max", "-o", in(folder, "s.h5")});
  std::filesystem::rename(folder / "s.h5", folder / "s.h5.partial");
  const Ended ended = run_trilat(folder, {"recover", in(folder, "s.h5")});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("was finished, but for its name"));
  EXPECT_TRUE(SessionReader(folder / "s.h5").complete());
  EXPECT_FALSE(std::filesystem::exists(in(folder, "s.h5.partial")));
}

TEST(Record, TwoRecordersCannotHaveOneName) {
  const ScratchFolder folder;
  const std::vector<std::string> record{"record", "--source", "synthetic:1,depth=no", "-o",
                                        in(folder, "s.h5")};
  const Process first(folder, record, "first_");
  wait_for([&] { return std::filesystem::exists(in(folder, "s.h5.trilog")); });
  expect_refused(run_trilat(folder, record), "is being written by another recorder");
  first.interrupt();
  EXPECT_EQ(first.wait().code, 0);
  EXPECT_TRUE(SessionReader(folder / "s.h5").complete());
}

TEST(Record, ADisplayThatTakesNothingHoldsUpNobody) {
  const ScratchFolder folder;
  const std::string command = std::string(kProgram) + " record --source synthetic:1,depth=no,duration=1 -o " +
                              in(folder, "s.h5") + " >/dev/null 2>/dev/full";
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_TRUE(SessionReader(folder / "s.h5").complete());
}

// Two sensors see one person from two sides, one of them 4 cm off: the mean, as the first sees it.
TEST(SkeletonPreview, DrawsThePersonWhomAllSensorsSeeTogether) {
  const RigidTransform first = world_from_sensor_looking_at({0.0, 1.0, 2.0}, {0.0, 1.0, 0.0}),
                       second = world_from_sensor_looking_at({2.0, 1.0, 0.0}, {0.0, 1.0, 0.0});
  const Eigen::Vector3d head(0.1, 1.7, 0.0), off(0.0, 0.0, 0.04);
  const auto frame_with = [](const Eigen::Vector3d& in_sensor) {
    BodyFrame frame;
    frame.bodies.resize(2);  // one of nobody
    Body& body = frame.bodies[1];
    constexpr auto kHead = static_cast<std::size_t>(Joint::head);
    Eigen::Map<Eigen::Vector3f>(body.position_m[kHead].data()) = in_sensor.cast<float>();
    body.tracking_state[kHead] = 2;
    return frame;
  };
  const BodyFrame fused = fused_frame(
      {frame_with(first.inverse() * head), frame_with(second.inverse() * (head + off))}, {first, second});
  ASSERT_EQ(fused.bodies.size(), 1u);
  const Body& body = fused.bodies[0];
  const auto& p = body.position_m[static_cast<std::size_t>(Joint::head)];
  const Eigen::Vector3d seen(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
  EXPECT_LT((first * seen - (head + 0.5 * off)).norm(), 1e-6);
  EXPECT_EQ(std::ranges::count(body.tracking_state, 2), 1);
}

// A body that stands upright in the middle: its spine is one column of dots.
TEST(SkeletonPreview, DrawsBonesWhereTheSensorSeesThem) {
  BodyFrame frame;
  frame.bodies.resize(1);
  Body& body = frame.bodies[0];
  for (const Joint joint : {Joint::spine_base, Joint::spine_mid}) {
    body.position_m[static_cast<std::size_t>(joint)] = {0.0f, joint == Joint::spine_base ? -0.5f : 0.5f,
                                                        2.0f};
    body.tracking_state[static_cast<std::size_t>(joint)] = 2;
  }
  const DepthIntrinsics intrinsics;
  const auto text = skeleton_text(frame, intrinsics, 40);
  ASSERT_EQ(text.size(), 16u);
  const std::string empty = skeleton_text({}, intrinsics, 40)[8];
  EXPECT_EQ(empty.size(), 3u * 40);
  std::size_t drawn = 0;
  for (const std::string& row : text) {
    EXPECT_EQ(row.size(), empty.size());
    for (std::size_t c = 0; c < 40; ++c)
      if (row.substr(3 * c, 3) != empty.substr(0, 3)) {
        ++drawn;
        EXPECT_NEAR(static_cast<double>(c), 40.0 * intrinsics.cx_px / intrinsics.width_px, 1.0);
      }
  }
  EXPECT_NEAR(static_cast<double>(drawn), 16.0 * 183.0 / 424.0, 2.0);  // 1 m at 2 m is 183 px of 424
}

}  // namespace
}  // namespace trilat
