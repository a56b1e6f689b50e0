// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/results/item_store.h"
#include "datasets/rig/calibration.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/take/take_checks.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/rewritten_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

constexpr std::uint64_t kFirstOther = 500, kSecondOther = 600;

// One walk of one person, seen by four sensors, to which others can be added.
struct Walk {
  ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(1, 6.0));
  Take take = campaign.takes[0];
  std::vector<SensorPose> poses = read_calibration(take.calibration).sensors;

  ResultsSummary evaluated(const std::function<void(std::size_t, BodyFrame&)>& change) {
    campaign.takes[0] = take;
    change_session(campaign.takes[0], folder / "changed.h5", {[&](std::size_t s, BodyFrame& frame) {
                     change(s, frame);
                     return true;
                   }});
    return execute_study(study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}])"), campaign,
                         folder / "results", {});
  }
  // The samples of the person alone.
  std::string alone(const std::function<void(std::size_t, BodyFrame&)>& change = [](std::size_t, BodyFrame&) {
  }) {
    evaluated(change);
    return samples();
  }
  std::string samples() { return read_file(result_takes(folder / "results")[0].folder / StoredTake::kName); }
  Body other(std::size_t sensor, double x_m, double z_m, std::uint64_t id) {
    return body_at(poses.at(sensor), x_m, z_m, id + sensor);
  }
  // Two who stand around, the nearer one in the middle of the room.
  void add_both(std::size_t s, BodyFrame& frame) {
    frame.bodies.insert(frame.bodies.begin(), other(s, 0.0, 0.0, kFirstOther));
    frame.bodies.push_back(other(s, 1.5, -1.5, kSecondOther));
  }
};

std::string note_of(const ResultsSummary& summary) {
  return summary.notes.empty() ? "no note" : summary.notes.front().text;
}

TEST(PersonChoice, OfThreeTheOneWithTheMarkersIsTakenThoughAnotherIsNearerToTheMiddle) {
  Walk walk;
  const std::string alone = walk.alone();
  const ResultsSummary summary = walk.evaluated([&](std::size_t s, BodyFrame& f) { walk.add_both(s, f); });
  EXPECT_EQ(summary.takes_failed, 0u);
  EXPECT_THAT(note_of(summary), HasSubstr("they are 3 persons"));
  EXPECT_TRUE(walk.samples() == alone);
}

TEST(PersonChoice, ASensorThatOnlySeesTheOtherPersonSaysNothing) {
  Walk walk;
  const std::string alone = walk.alone([](std::size_t s, BodyFrame& frame) {
    if (s == 2) frame.bodies.clear();
  });
  const ResultsSummary summary = walk.evaluated([&](std::size_t s, BodyFrame& frame) {
    if (s == 2) frame.bodies.clear();
    walk.add_both(s, frame);
  });
  EXPECT_EQ(summary.takes_failed, 0u);
  EXPECT_TRUE(walk.samples() == alone);
}

// Nobody ever sees two at once, so that only the places tell that one of them is somebody else.
TEST(PersonChoice, ABystanderWhomOneSensorSeesInsteadOfThePersonIsLeftOut) {
  Walk walk;
  const std::string alone = walk.alone([](std::size_t s, BodyFrame& frame) {
    if (s == 2) frame.bodies.clear();
  });
  const ResultsSummary summary = walk.evaluated([&](std::size_t s, BodyFrame& frame) {
    if (s == 2) frame.bodies = {walk.other(s, 1.8, -1.8, kFirstOther)};
  });
  EXPECT_EQ(summary.takes_failed, 0u);
  EXPECT_THAT(note_of(summary), HasSubstr("2 persons"));
  EXPECT_TRUE(walk.samples() == alone);
}

TEST(PersonChoice, IdsThatChangeAreFollowed) {
  Walk walk;
  const std::string alone = walk.alone();
  walk.evaluated([&](std::size_t s, BodyFrame& frame) {
    for (Body& body : frame.bodies) body.tracking_id += 10'000 * (1 + (frame.stamp.sequence + 7 * s) / 40);
    walk.add_both(s, frame);
    if (frame.stamp.sequence > 90)
      for (Body& body : frame.bodies) body.tracking_id += 100;  // everybody's at once
  });
  EXPECT_TRUE(walk.samples() == alone);
}

// Too long away for the matching to link what comes after to what was before; the markers can.
TEST(PersonChoice, APersonWhomNobodySeesForLongIsTakenBeforeAndAfter) {
  Walk walk;
  const auto vanish = [](std::size_t, BodyFrame& frame) {
    if (frame.stamp.sequence >= 30 && frame.stamp.sequence < 145) frame.bodies.clear();
    for (Body& body : frame.bodies) body.tracking_id += frame.stamp.sequence < 100 ? 0 : 10'000;
  };
  const std::string alone = walk.alone(vanish);
  walk.evaluated([&](std::size_t s, BodyFrame& frame) {
    vanish(s, frame);
    walk.add_both(s, frame);
  });
  EXPECT_TRUE(walk.samples() == alone);
}

TEST(PersonChoice, WhereNobodyIsNearTheMarkersTheNoteSaysHowFarThatIs) {
  Walk walk;
  const ResultsSummary summary = walk.evaluated([&](std::size_t s, BodyFrame& frame) {
    frame.bodies.clear();
    frame.bodies.push_back(walk.other(s, 5.0, 5.0, kFirstOther));
    frame.bodies.push_back(walk.other(s, -5.0, 5.0, kSecondOther));
  });
  EXPECT_THAT(note_of(summary), testing::ContainsRegex("in the median [67]\\.[0-9]+ m from the middle"));
}

// With a calibration in another world the truth does not tell who is who.
TEST(PersonChoice, ATruthInAnotherWorldSortsNobodyOutWhereNobodyIsBesideThem) {
  Walk walk;
  Calibration moved = read_calibration(walk.take.calibration);
  for (SensorPose& pose : moved.sensors)
    pose.world_from_sensor.translation_m += Eigen::Vector3d(7.0, 0.0, 3.0);
  write_calibration(walk.folder / "moved.json", moved);
  walk.take.calibration = walk.folder / "moved.json";
  const ResultsSummary summary = walk.evaluated([](std::size_t, BodyFrame&) {});
  EXPECT_THAT(note_of(summary),
              testing::HasSubstr("lies in another frame than what the sensors see, shifted by (7.00"));
  EXPECT_EQ(summary.takes_failed, 0u);
}

TEST(PersonChoice, OneBodyThatComesAndGoesWithNewIdsNeedsNoChoice) {
  Walk walk;
  const std::string alone = walk.alone();
  const ResultsSummary summary = walk.evaluated([](std::size_t, BodyFrame& frame) {
    for (Body& body : frame.bodies) body.tracking_id += 1000 * (frame.stamp.sequence / 20);
  });
  EXPECT_EQ(note_of(summary), "no note");
  EXPECT_TRUE(walk.samples() == alone);
}

}  // namespace
}  // namespace trilat
