// SPDX-License-Identifier: MIT
// fuzz_seeds FOLDER: small sound files for the fuzzers to begin with, in a folder for each.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/base/files.h"
#include "datasets/mocap/mocap_writer.h"
#include "datasets/session/event_log.h"
#include "datasets/session/session_writer.h"
#include "recorders/link/messages.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

// Gives the path of a new seed of a fuzzer.
using SeedPath = std::function<fs::path(const std::string& fuzzer, const std::string& name)>;

void write_session(const fs::path& path) {
  SessionHeader header;
  header.sensors.resize(1);
  header.sensors[0].name = "k1";
  header.sensors[0].has_depth = true;
  SessionWriter writer(path, header);
  const std::vector<std::uint16_t> depth_mm(kDepthPixels, 1000);
  for (std::int64_t i = 0; i < 3; ++i) {
    const FrameStamp stamp{i, 333'333 * i, 33'333'300 * i};
    writer.add_body_frame(0, {stamp, {}, {Body{.tracking_id = 7}}});
    writer.add_depth_frame(0, encode_depth_frame(stamp, depth_mm, ChunkCompression::blosc));
    writer.add_clock_exchange(0, {33'333'300 * i, 33'333'400 * i, 33'333'500 * i, 33'333'600 * i});
  }
  writer.add_notice(0, {5, "back again"});
  writer.finish();
}

void write_log(const fs::path& path) {
  LogHead head{.id = 1, .agent = "k1", .session = {}};
  head.session.sensors.resize(1);
  fs::remove(path);
  EventLogWriter log(path, head);
  log.append(0, BodyFrame{{1, 2, 3}, {}, {Body{.tracking_id = 7}}});
  log.append(0, EncodedDepthFrame{{1, 2, 3}, std::vector<std::byte>(20), ChunkCompression::none});
  log.append(0, ClockExchange{1, 2, 3, 4});
  log.append(0, DropCount{1, 2, 3});
  log.append(0, SensorNotice{5, "back again"});
  log.finish("unplugged");
}

// Motive's columns, as our own writer lays them out.
void write_motive(const fs::path& path) {
  MocapHeader header;
  header.take_name = "walk";
  header.capture_rate_hz = header.export_rate_hz = 100.0;
  header.assets = {{AssetType::rigid_body, "Wand", "1F", "", true}, {AssetType::marker, "a", "2A", "", true}};
  OptitrackCsvWriter writer(path, header);
  for (std::int64_t i = 0; i < 3; ++i) {
    std::vector<Eigen::Vector3d> position_m{{1.0, 2.0, 3.0}, Eigen::Vector3d::Constant(kNaN)};
    if (i != 1) position_m[1] = {0.5, 0.25, 0.125};
    writer.write(i, position_m);
  }
  writer.finish();
}

constexpr const char* kTrc =
    "PathFileType\t4\t(X/Y/Z)\twalk.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
    "100\t100\t2\t2\tmm\t100\t1\t2\nFrame#\tTime\ta\t\t\tb\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
    "1\t0.00\t1500\t250.5\t-1e2\t\t\t\n2\t0.01\tnan\tnan\tnan\t4\t5\t6\n";

void write_link_seeds(const SeedPath& seed) {
  write_file(seed("address", "mapped"), "[::ffff:127.0.0.1]:7345");
  std::string bytes;
  for (const Message& message : {Message(HelloMessage{LinkRole::data, "k1", 1, 2, 3}),
                                 Message(BytesMessage{5, 6, {}}), Message(LiveMessage{0, BodyFrame{}})})
    for (const std::byte byte : encode_message(message)) bytes.push_back(static_cast<char>(byte));
  write_file(seed("messages", "hello_and_bytes"), bytes);
}

void write_seeds(const fs::path& folder) {
  const auto seed = [&](const std::string& fuzzer, const std::string& name) {
    make_folder(folder / fuzzer);
    return folder / fuzzer / name;
  };
  write_session(seed("session", "three_frames"));
  write_log(seed("event_log", "every_kind"));
  for (const char* reader : {"mocap", "mocap_summary"}) {
    write_motive(seed(reader, "motive"));
    write_file(seed(reader, "trc"), kTrc);
  }
  write_file(seed("joint_csv", "two"),
             "time_s,joint,x_m,y_m,z_m\n0,head,0.1,1.7,2\n0,knee_left,,,\n0.02,head,0.1,1.7,2.1\n");
  write_link_seeds(seed);
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: fuzz_seeds FOLDER\n");
    return 2;
  }
  try {
    trilat::write_seeds(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuzz_seeds: %s\n", error.what());
    return 2;
  }
}
