// SPDX-License-Identifier: MIT
// Outcomes of a calibration study that were damaged or written by hand are refused where they stand.
#include <array>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/results/items.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "tests/pipeline/program.h"

namespace trilat {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kStudy = R"({"format": "trilat.study", "version": 1, "kind": "calibration",
    "name": "tiny", "units": 1, "samples": 1, "near_samples": 1, "frames": 1, "distortion_units": 1,
    "distortion_frames": 1, "runs": 1, "positions": 3, "position_frames": 1, "bodies_s": 0, "effect_joints": 0})";

struct StudyOutcomes : testing::Test {
  ScratchFolder folder;

  void SetUp() override {
    write_file(folder / "study.json", kStudy);
    const Ended ended = run_trilat(folder, {"run", (folder / "study.json").string(), "--shard", "1/1", "-o",
                                            (folder / "part").string()});
    ASSERT_EQ(ended.code, 0) << ended.err;
  }

  // What merging says when `change` was made to the outcome of the item.
  template <class Change>
  std::string said(const std::string& id, const Change& change) const {
    const auto file = item_folder(folder / "part", id) / kItemFile;
    const Json good = read_json(file);
    Json item = good;
    change(item["outcome"]);
    write_file(file, json_text(item, 1));
    const std::string message = message_of([&] {
      const auto parts = read_parts(std::array{folder / "part"});
      merge_parts(calibration_study(parse_calibration_spec(parts[0].part.work, "part.json")), parts,
                  folder / "merged", {.threads = 1});
    });
    write_file(file, json_text(good, 1));
    return message;
  }
};

TEST_F(StudyOutcomes, OfTheDistortionAreReadStrictly) {
  const auto with = [&](const char* key, const Json& value) {
    return said("distortion/unit-0", [&](Json& outcome) { outcome[key] = value; });
  };
  EXPECT_THAT(with("valid", Json::array({1})), AllOf(HasSubstr("distortion/unit-0/item.json outcome /valid"),
                                                     HasSubstr("array of 512 counts")));
  EXPECT_THAT(with("valid", Json::array_t(512, -1e300)), HasSubstr("must hold integers >= 0"));
  EXPECT_THAT(with("lens_error_m", Json::array_t(511, 0.0)), HasSubstr("/lens_error_m"));
  EXPECT_THAT(with("valid", Json::array_t(512, 2)), HasSubstr("counts more frames than there are"));
  EXPECT_THAT(with("more", 1), HasSubstr("more"));
}

TEST_F(StudyOutcomes, OfTheWandAreReadStrictly) {
  const auto with = [&](const char* pointer, const Json& value) {
    return said("wand/unit-0", [&](Json& outcome) { outcome[Json::json_pointer(pointer)] = value; });
  };
  EXPECT_THAT(with("/images", Json::array()), HasSubstr("wand/unit-0/item.json outcome /images: must be 4"));
  EXPECT_THAT(with("/images/0/error_m", Json::array({0.1})), HasSubstr("/images/0/error_m"));
  EXPECT_THAT(with("/images/0/error_m/0", -5.0), HasSubstr("must be 0 or more"));
  EXPECT_THAT(with("/images/0/distance_error_m/0", -5.0),
              HasSubstr("/images/0/distance_error_m: must be 0 or more"));
  EXPECT_THAT(with("/images/1/status/0", 7), HasSubstr("must hold numbers of statuses"));
  EXPECT_THAT(with("/images/1/status/0", 1.5), HasSubstr("/images/1/status"));
}

TEST_F(StudyOutcomes, OfTheRigsAreReadStrictly) {
  const auto with = [&](const char* pointer, const Json& value) {
    return said("rigs/run-0", [&](Json& outcome) { outcome[Json::json_pointer(pointer)] = value; });
  };
  EXPECT_THAT(with("/methods/0/position_m", Json::array_t(100, 0.0)),
              HasSubstr("one number for each sensor that is placed"));
  EXPECT_THAT(with("/methods/0/covered", Json::array({-1})), HasSubstr("/methods/0/covered"));
  EXPECT_THAT(with("/methods/0/poses_wxyz_m", Json::array({1.0})), HasSubstr("/methods/0/poses_wxyz_m"));
  EXPECT_THAT(with("/methods/7/position_m/0", -1.0), HasSubstr("what no pose's error is"));
  EXPECT_THAT(with("/methods/7/covered/0", 99), HasSubstr("what no pose's error is"));
  EXPECT_THAT(with("/methods/7/poses_wxyz_m/0", 2.0), HasSubstr("rotations of unit length"));
  EXPECT_THAT(with("/methods/7/poses_wxyz_m/4", nullptr), HasSubstr("rotations of unit length"));
  EXPECT_THAT(said("rigs/run-0", [](Json& outcome) { outcome["methods"][0].erase("failed"); }),
              HasSubstr("/methods/0/failed: is missing"));
  EXPECT_THAT(with("/methods", Json::array()),
              HasSubstr("rigs/run-0/item.json outcome /methods: must be 14"));
}

TEST_F(StudyOutcomes, AsTheyWereWrittenMakeAStudy) {
  EXPECT_EQ(said("rigs/run-0", [](Json&) {}), "no error");
}

}  // namespace
}  // namespace trilat
