// SPDX-License-Identifier: MIT
// fuzz_seeds FOLDER: small sound files for the fuzzers to begin with, in a folder for each.
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "datasets/base/files.h"
#include "datasets/markers/joint_files.h"
#include "datasets/mocap/optitrack_csv_writer.h"
#include "datasets/session/session_writer.h"
#include "recorders/network/link/wire.h"
#include "tests/datasets/import/made_up_xef.h"
#include "tests/fuzz/chosen_seeds.h"

namespace trilat {
namespace {

std::string joints(const std::string& text, const std::string& between = "") {
  std::string all;
  for (int j = 0; j < kJointCount; ++j) all += (j == 0 ? "" : between) + text;
  return all;
}

std::string ntu_seed() {
  const std::string body = "72057594037931648 0 1 3 0 2 0 0.25 -0.125 2\n25\n" +
                           joints("0.1 0.2 2.5 270 180 900 500 0.9 0.1 0.2 0.3 2\n");
  return "3\n1\n" + body + "0\n2\n" + body + body;
}

std::string node_kinect2_seed() {
  const std::string joint = R"({"depthX":0.5,"depthY":0.5,"cameraX":0.1,"cameraY":0.2,"cameraZ":2.5,)"
                            R"("orientationX":0,"orientationY":0,"orientationZ":0,"orientationW":1})";
  const std::string front =
      R"({"tracked":true,"trackingId":"72057594037931648","leftHandState":3,"rightHandState":2,)"
      R"("joints":[)" +
      joints(joint, ",") + R"(],"record_startime":1518026639637,"record_timestamp":)";
  return "[" + front + "11}," + front + "44}]";
}

std::string kimore_seed() {
  const std::string row = joints("0.1,0.2,2.5,2,") + "\n";
  return "\n" + row + row + '\0' + "\n1000\n334333\n" + '\0' + "\n" + row + row;
}

std::string xef_seed(bool archived) {
  MadeUpXef xef(2, archived);
  xef.describe(1, kXefDepth);
  xef.describe(2, kXefBodies);
  for (const int i : {0, 1}) {
    if (archived)
      xef.event(1, 333'333 * i, static_cast<std::uint32_t>(i), std::string(xef::kDepthBytes, '\0'));
    xef.event(2, 333'333 * i, static_cast<std::uint32_t>(i), made_up_bodies(i, 7));
  }
  if (!archived) xef.footer();
  return xef.bytes();
}

std::string big_endian(std::uint32_t value) {
  std::string text;
  for (const int shift : {24, 16, 8, 0}) text += static_cast<char>(value >> shift);
  return text;
}

std::string png_chunk(const std::string& type, const std::string& data) {
  const std::string text = type + data;
  const auto sum = ::crc32(0, reinterpret_cast<const Bytef*>(text.data()), static_cast<uInt>(text.size()));
  return big_endian(static_cast<std::uint32_t>(data.size())) + text +
         big_endian(static_cast<std::uint32_t>(sum));
}

std::string png_seed() {
  const std::string rows(kDepthHeight * std::size_t{1 + 2 * kDepthWidth}, '\0');
  uLongf size = compressBound(rows.size());
  std::string deflated(size, '\0');
  compress(reinterpret_cast<Bytef*>(deflated.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
           rows.size());
  deflated.resize(size);
  const std::string shape =
      big_endian(kDepthWidth) + big_endian(kDepthHeight) + std::string("\x10\0\0\0\0", 5);
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", shape) + png_chunk("IDAT", deflated) + png_chunk("IEND", "");
}

std::string wire_seed() {
  HelloMessage hello;
  hello.agent = "k1";
  hello.sensors.resize(1);
  std::string bytes;
  for (const Message& message :
       {Message(hello), Message(EventMessage{0, 0, BodyFrame{}}), Message(ByeMessage{1})})
    for (const std::byte byte : encode_message(message)) bytes.push_back(static_cast<char>(byte));
  return bytes;
}

void write_session(const std::filesystem::path& path) {
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

// Motive's columns, as our own writer lays them out.
void write_motive(const std::filesystem::path& path) {
  MocapHeader header;
  header.take_name = "walk";
  header.capture_rate_hz = header.export_rate_hz = 100.0;
  header.assets = {{AssetType::rigid_body, "Wand", "1F", "", true, true},
                   {AssetType::marker, "a", "2A", "", false, true}};
  OptitrackCsvWriter writer(path, header);
  for (std::int64_t i = 0; i < 3; ++i) {
    MocapFrame frame{i, {10'000'000 * i}, kMissing, std::vector<MocapPose>(2)};
    frame.poses[0] = {{1.0, 2.0, 3.0}, Eigen::Quaterniond::Identity()};
    if (i != 1) frame.poses[1].position_m = {0.5, 0.25, 0.125};
    writer.write(frame);
  }
  writer.finish();
}

// Rows of the older formats, whose lines say what they are.
constexpr const char* kRowFormat =
    "comment,\"own\"\ninfo,version,1.1\ninfo,framecount,2\ninfo,rigidbodycount,1\n"
    "rigidbody,\"Body 1\",1,1,0,0,0\n"
    "frame,0,0.00000000,1,1,1,2,3,0.6,0,0,0.8,0,0,0,1,1,2,3,6,Body 1-Marker 1\n"
    "rigidbody,0,0.00000000,\"Body 1\",1,0,1,1,2,3,6,1,2,3.5,1,0.5,0.001\n"
    "frame,1,0.00833333,1,1,1,2,3,0.6,0,0,0.8,0,0,0,1,1,2,3,6,Body 1-Marker 1\n";

constexpr const char* kTrc =
    "PathFileType\t4\t(X/Y/Z)\twalk.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
    "100\t100\t2\t2\tmm\t100\t1\t2\nFrame#\tTime\ta\t\t\tb\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
    "1\t0.00\t1500\t250.5\t-1e2\t\t\t\n2\t0.01\tnan\tnan\tnan\t4\t5\t6\n";

void write_points(const std::filesystem::path& path) {
  write_c3d(path, {{"a", "b"}, 100.0, 2, [](JointFrame& frame) {
                     frame.time_s += frame.position_m.empty() ? 0.0 : 0.01;
                     frame.position_m = {{1.0, 2.0, 3.0}, Eigen::Vector3d::Constant(kMissing)};
                   }});
}

constexpr const char* kIntrinsics =
    "%YAML:1.0\n---\ncameraMatrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 365.4, 0., 254.8, 0., 365.4, 205.3, 0., 0., 1. ]\n"
    "distortionCoefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n"
    "   data: [ 0.09, -0.26, 0., 0., 0.09 ]\n";

void write_seeds(const std::filesystem::path& folder) {
  const auto seed = [&](const std::string& fuzzer, const std::string& name) {
    make_folder(folder / fuzzer);
    return folder / fuzzer / name;
  };
  write_file(seed("kimore", "two_rows"), kimore_seed());
  write_file(seed("labanotation", "two_rows"),
             "1000," + joints("0.1,0.2,2.5,2,") + "\n334333," + joints("0,0,2,1,"));
  write_file(seed("node_kinect2", "two_frames"), node_kinect2_seed());
  write_file(seed("ntu", "three_frames"), ntu_seed());
  write_file(seed("png", "zeros"), png_seed());
  write_file(seed("xef", "plain"), xef_seed(false));
  write_file(seed("xef", "archived"), xef_seed(true));
  write_file(seed("wire", "hello_and_bye"), wire_seed());
  write_session(seed("session", "three_frames"));
  write_motive(seed("mocap", "motive"));
  write_file(seed("mocap", "rows"), kRowFormat);
  write_file(seed("mocap", "trc"), kTrc);
  write_points(seed("mocap", "c3d"));
  write_file(seed("umons_taichi", "two_rows"), "0" + joints(" 0.1 0.2 2.5") + "\n33" + joints(" 0 0 2"));
  write_file(seed("intrinsics", "kinect"), kIntrinsics);
  write_settings_seeds(seed);
  write_results_seeds(seed, folder / "sound_results");
  write_tls_seeds(seed);
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
