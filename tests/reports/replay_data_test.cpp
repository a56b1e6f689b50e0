// SPDX-License-Identifier: MIT
#include "reports/page/replay_data.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <zlib.h>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/replay.h"
#include "datasets/skeleton/skeleton.h"
#include "reports/figures/figure_look.h"
#include "reports/page/html.h"
#include "reports/write_report.h"
#include "tests/reports/summaries.h"
#include "tests/reports/written_samples.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr std::uint64_t kInstants = 3;
constexpr std::size_t kSensors = 2, kJoints = 2, kMethods = 1;

ReplayTake seen_take() {
  ReplayTake take;
  take.id = "p01";
  take.condition = "walking";
  take.sensors = {"k1", "k2"};
  take.world_from_sensor.resize(kSensors);
  take.reset(kInstants, kSensors);
  for (std::uint64_t i = 0; i < kInstants; ++i) {
    take.joint_m[i * kSensors * kJointCount * 3] = 0.1f * static_cast<float>(i);
    take.state[i * kSensors * kJointCount] = static_cast<std::uint8_t>(TrackingState::tracked);
  }
  return take;
}

// Truth at 1 m, the estimate 5 cm above it and unanswered at the last instant.
std::filesystem::path replayed_results(const ScratchFolder& folder) {
  write_samples(
      folder / "results", samples_of({"nonlinear"}, {{"p01", 5, "walking"}}),
      [](std::size_t, double, std::size_t) { return 1.0; },
      [](std::size_t, double time_s, std::size_t, std::size_t) { return time_s > 0.05 ? kNoNumber : 1.05; });
  write_summary(folder / "results", hand_made_summary());
  write_replay(folder / "results", std::vector{seen_take()});
  return folder / "results";
}

// The numbers as the page unpacks them.
struct Unpacked {
  std::vector<int> numbers;  // [channel * instants + instant]
  std::vector<int> states;
  explicit Unpacked(const PackedReplay& packed) {
    const std::size_t channels = (kSensors * kJointCount + kJoints + kJoints * kMethods) * 3;
    std::string bytes((channels * 2 + kSensors * kJointCount) * kInstants, '\0');
    uLongf size = bytes.size();
    EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                         reinterpret_cast<const Bytef*>(packed.bytes.data()), packed.bytes.size()),
              Z_OK);
    EXPECT_EQ(size, bytes.size());
    const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
    for (std::size_t c = 0, at = 0; c < channels; ++c) {
      std::uint16_t value = 0;
      for (std::uint64_t i = 0; i < kInstants; ++i, at += 2) {
        value = static_cast<std::uint16_t>(value + byte(at) + (byte(at + 1) << 8));
        numbers.push_back(static_cast<std::int16_t>(value));
      }
    }
    for (std::size_t at = channels * 2 * kInstants; at < bytes.size(); ++at) states.push_back(byte(at));
  }
  int number(std::size_t channel, std::uint64_t i) const { return numbers[channel * kInstants + i]; }
};

TEST(ReplayData, HoldsMillimetresOfSensorsTruthAndAnswersOnly) {
  const ScratchFolder folder;
  const auto packed = packed_replays(replayed_results(folder), hand_made_summary());
  ASSERT_EQ(packed.size(), 1u);
  const Unpacked data(packed[0]);
  EXPECT_EQ(data.number(0, 0), 0);
  EXPECT_EQ(data.number(0, 2), 200);
  EXPECT_EQ(data.number(1, 0), -32768);  // NaN
  const std::size_t truth = kSensors * kJointCount * 3, estimate = truth + kJoints * 3;
  EXPECT_EQ(data.number(truth + 1, 0), 1000);
  EXPECT_EQ(data.number(truth, 0), 8000);
  EXPECT_EQ(data.number(estimate + 1, 0), 1050);
  EXPECT_EQ(data.number(estimate + 1, 2), -32768);  // not answered
  EXPECT_EQ(data.states[0], 2);
}

TEST(ReplayData, ItsHeaderNamesWhatTheChannelsAre) {
  const ScratchFolder folder;
  const Json head =
      parse_json(packed_replays(replayed_results(folder), hand_made_summary()).at(0).header, "header");
  EXPECT_EQ(head.at("instants"), kInstants);
  EXPECT_EQ(head.at("sensors").size(), kSensors);
  EXPECT_EQ(head.at("joints"), Json({"head", "wrist_right"}));
  EXPECT_EQ(head.at("methods"), Json({"nonlinear"}));
  EXPECT_EQ(head.at("colours"), Json({look_of_method("nonlinear").colour}));  // as in the figures
  EXPECT_EQ(head.at("simulated"), true);
  EXPECT_NEAR(head.at("span_s").get<double>(), 2.0 / 30.0, 1e-6);
}

TEST(ReplayData, AFileOfAnotherRunIsRefused) {
  const ScratchFolder folder;
  const auto results = replayed_results(folder);
  ReplayTake other = seen_take();
  other.id = "p02";
  write_replay(results, std::vector{other});
  EXPECT_THAT(message_of([&] { packed_replays(results, hand_made_summary()); }),
              HasSubstr("replay.h5: is not of the run that samples.h5 beside it is of: take \"p02\""));
}

TEST(ReplayData, ThePageHoldsItOrSaysWhyNot) {
  const ScratchFolder folder;
  const auto results = replayed_results(folder);
  write_file(folder / "three.js", "/* three */");
  const auto page = [&](const std::string& three) {
    write_report({results}, folder / "report", {.made = "then", .three_js = folder / three});
    return read_file(folder / "report/report.html");
  };
  const std::string with = page("three.js");
  EXPECT_THAT(with, HasSubstr("id=\"replay-view\""));
  EXPECT_THAT(with, HasSubstr("<script type=\"text/plain\" id=\"three-js\">" +
                              base64_of(deflated("/* three */")) + "</script>"));
  const std::string without = page("absent.js");
  EXPECT_THAT(without, HasSubstr("Install the Debian package <code>libjs-three</code>"));
  EXPECT_THAT(without, Not(HasSubstr("replay-bytes\">")));
  std::filesystem::remove(results / "replay.h5");
  EXPECT_THAT(page("three.js"), HasSubstr("none of the results holds a replay.h5"));
}

}  // namespace
}  // namespace trilat
