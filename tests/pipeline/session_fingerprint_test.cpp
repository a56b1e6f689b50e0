// SPDX-License-Identifier: MIT
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "datasets/geometry/depth_camera.h"
#include "datasets/session/session_writer.h"
#include "pipeline/calibration/wand_study.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

struct Recorded {
  SessionHeader header;
  std::vector<BodyFrame> bodies = std::vector<BodyFrame>(5);
  std::vector<FrameStamp> images = std::vector<FrameStamp>(3);
  std::uint16_t depth_mm = 1500;
  ClockExchange exchange{.t1_ns = 10, .t2_ns = 20, .t3_ns = 30, .t4_ns = 40};
};

Recorded recorded() {
  Recorded made;
  SensorDescription& sensor = made.header.sensors.emplace_back();
  sensor.name = "k1";
  sensor.serial = "serial1";
  sensor.source = "simulated";
  sensor.has_depth = true;
  for (std::size_t f = 0; f < made.bodies.size(); ++f)
    made.bodies[f].stamp = {.sequence = static_cast<std::int64_t>(f), .device_ticks = 7, .arrival_ns = 9};
  for (std::size_t f = 0; f < made.images.size(); ++f)
    made.images[f] = {.sequence = static_cast<std::int64_t>(f), .device_ticks = 8, .arrival_ns = 10};
  return made;
}

void write(const std::filesystem::path& path, const Recorded& recorded) {
  SessionWriter writer(path, recorded.header);
  const std::vector<std::uint16_t> depth_mm(kDepthPixels, recorded.depth_mm);
  for (const BodyFrame& frame : recorded.bodies) writer.add_body_frame(0, frame);
  for (const FrameStamp& stamp : recorded.images)
    writer.add_depth_frame(0, encode_depth_frame(stamp, depth_mm, ChunkCompression::blosc));
  writer.add_clock_exchange(0, recorded.exchange);
  writer.finish();
}

std::string fingerprint_at(const std::filesystem::path& path) { return fingerprint_of(SessionReader(path)); }

TEST(SessionFingerprint, IsOfTheContentAndNotOfTheName) {
  ScratchFolder folder;
  write(folder / "session.h5", recorded());
  std::filesystem::copy(folder / "session.h5", folder / "copy.h5");
  EXPECT_EQ(fingerprint_at(folder / "copy.h5"), fingerprint_at(folder / "session.h5"));
}

// Each change leaves the file as long as it was: it is what the file says that is told apart.
TEST(SessionFingerprint, TellsApartWhatIsRecorded) {
  ScratchFolder folder;
  write(folder / "session.h5", recorded());
  const std::string fingerprint = fingerprint_at(folder / "session.h5");
  const std::vector<std::pair<std::string, std::function<void(Recorded&)>>> changes{
      {"serial", [](Recorded& r) { r.header.sensors[0].serial = "serial2"; }},
      {"latency", [](Recorded& r) { r.header.sensors[0].latency_ns += 1; }},
      {"body stamp", [](Recorded& r) { r.bodies.back().stamp.arrival_ns += 1; }},
      {"depth stamp", [](Recorded& r) { r.images.back().device_ticks += 1; }},
      {"depth", [](Recorded& r) { r.depth_mm *= 2; }},
      {"clock exchange", [](Recorded& r) { r.exchange.t2_ns += 1; }}};
  for (const auto& [name, change] : changes) {
    Recorded changed = recorded();
    change(changed);
    write(folder / (name + ".h5"), changed);
    EXPECT_EQ(std::filesystem::file_size(folder / (name + ".h5")),
              std::filesystem::file_size(folder / "session.h5"))
        << name;
    EXPECT_NE(fingerprint_at(folder / (name + ".h5")), fingerprint) << name;
  }
}

TEST(SessionFingerprint, TellsApartARecordingOfAnotherLength) {
  ScratchFolder folder;
  Recorded shorter = recorded();
  shorter.bodies.pop_back();
  write(folder / "session.h5", recorded());
  write(folder / "shorter.h5", shorter);
  EXPECT_NE(fingerprint_at(folder / "shorter.h5"), fingerprint_at(folder / "session.h5"));
}

}  // namespace
}  // namespace trilat
