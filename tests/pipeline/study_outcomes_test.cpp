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

using ::testing::HasSubstr;

constexpr const char* kStudy = R"({"format": "trilat.study", "version": 1, "kind": "calibration",
    "name": "tiny", "units": 1, "samples": 1, "near_samples": 1, "frames": 1, "distortion_units": 1,
    "distortion_frames": 1, "runs": 1, "positions": 3, "position_frames": 1, "bodies_s": 0})";

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

TEST_F(StudyOutcomes, ThatDoNotFitTheirStudyAreRefused) {
  const auto with = [&](const char* id, const char* pointer, const Json& value) {
    return said(id, [&](Json& outcome) { outcome[Json::json_pointer(pointer)] = value; });
  };
  EXPECT_THAT(with("distortion/unit-0", "/valid", Json::array({1})),
              HasSubstr("distortion/unit-0/item.json outcome /valid: must be as long as the curves"));
  EXPECT_THAT(with("wand/unit-0", "/images", Json::array()),
              HasSubstr("wand/unit-0/item.json outcome: must have 4 images"));
  EXPECT_THAT(with("wand/unit-0", "/images/0/error_m", Json::array({0.1})), HasSubstr("must have 4 images"));
  EXPECT_THAT(with("rigs/run-0", "/methods", Json::array()), HasSubstr("must have 6 methods"));
  EXPECT_THAT(with("rigs/run-0", "/methods/0/sensors/0/misfit/covered", -1),
              HasSubstr("/methods/0/sensors/0/misfit/covered: must be an integer of 0 or more"));
}

TEST_F(StudyOutcomes, AsTheyWereWrittenMakeAStudy) {
  EXPECT_EQ(said("rigs/run-0", [](Json&) {}), "no error");
}

}  // namespace
}  // namespace trilat
