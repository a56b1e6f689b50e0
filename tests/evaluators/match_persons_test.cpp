// SPDX-License-Identifier: MIT
#include "evaluators/bodies/match_persons.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;

using Path = std::function<Vector3d(double time_s)>;

// What a sensor sees of a path at 30 Hz: with a phase of its own, a constant error of 5 cm in a direction of
// its own, 1 cm of noise, and one frame in twenty dropped.
Tracklet seen(std::size_t sensor, const Path& path, double from_s, double to_s) {
  Tracklet tracklet;
  tracklet.sensor = sensor;
  const double phase_s = 0.007 * static_cast<double>(sensor);
  const double angle = 1.7 * static_cast<double>(sensor);
  const Vector3d bias_m = 0.05 * Vector3d(std::cos(angle), 0.0, std::sin(angle));
  for (int i = 0;; ++i) {
    const double time_s = from_s + phase_s + i / 30.0;
    if (time_s > to_s) break;
    const RandomStream random{3, Purpose::test,
                              random_item(sensor, 0, 0, static_cast<std::uint64_t>(time_s * 1000))};
    if (i > 0 && random.uniform(9) < 0.05) continue;
    tracklet.time_ns.push_back(std::llround(time_s * 1e9));
    tracklet.centre_in_world_m.push_back(
        path(time_s) + bias_m + 0.01 * Vector3d(random.normal(0), random.normal(1), random.normal(2)));
  }
  return tracklet;
}

Path standing(double x_m, double z_m = 0.0) {
  return [=](double) { return Vector3d(x_m, 1.0, z_m); };
}

std::vector<std::size_t> persons_of(const std::vector<Tracklet>& tracklets) {
  return match_persons(tracklets, {}).person_of_tracklet;
}

TEST(MatchPersons, TwoWhoWalkNinetyCentimetresApartAreTwo) {
  const Path left = [](double t) { return Vector3d(-0.45, 1.0, -1.5 + 0.5 * t); };
  const Path right = [](double t) { return Vector3d(0.45, 1.0, -1.5 + 0.5 * t); };
  std::vector<Tracklet> tracklets;
  for (std::size_t s = 0; s < 4; ++s) {
    tracklets.push_back(seen(s, left, 0.0, 6.0));
    tracklets.push_back(seen(s, right, 0.0, 5.0));
  }
  EXPECT_THAT(persons_of(tracklets), ElementsAre(0, 1, 0, 1, 0, 1, 0, 1));
}

TEST(MatchPersons, PathsThatCrossStayApartThoughIdsChangeAtTheCrossing) {
  const Path to_the_right = [](double t) { return Vector3d(-2.0 + 0.5 * t, 1.0, 0.15); };
  const Path to_the_left = [](double t) { return Vector3d(2.0 - 0.5 * t, 1.0, -0.15); };
  std::vector<Tracklet> tracklets{seen(0, to_the_right, 0.0, 8.0), seen(1, to_the_right, 0.0, 3.9),
                                  seen(1, to_the_right, 4.2, 8.0), seen(2, to_the_right, 0.0, 8.0),
                                  seen(0, to_the_left, 0.0, 7.5),  seen(1, to_the_left, 0.0, 4.1),
                                  seen(1, to_the_left, 4.3, 7.5),  seen(2, to_the_left, 3.6, 7.5)};
  EXPECT_THAT(persons_of(tracklets), ElementsAre(0, 0, 0, 0, 1, 1, 1, 1));
}

TEST(MatchPersons, ChangingIdsAreLinkedThroughAnotherSensorHoweverLongTheAbsence) {
  const std::vector<Tracklet> tracklets{seen(0, standing(0.0), 0.0, 5.0), seen(0, standing(0.0), 20.0, 25.0),
                                        seen(1, standing(0.0), 0.0, 25.0)};
  EXPECT_THAT(persons_of(tracklets), ElementsAre(0, 0, 0));
}

TEST(MatchPersons, OneSensorAloneLinksWhatFollowsNearInSpaceAndTime) {
  EXPECT_THAT(persons_of({seen(0, standing(0.0), 0.0, 5.0), seen(0, standing(0.3), 6.0, 9.0)}),
              ElementsAre(0, 0));
  EXPECT_THAT(persons_of({seen(0, standing(0.0), 0.0, 5.0), seen(0, standing(2.5), 6.0, 9.0)}),
              ElementsAre(0, 1));
  EXPECT_THAT(persons_of({seen(0, standing(0.0), 0.0, 5.0), seen(0, standing(0.0), 9.0, 12.0)}),
              ElementsAre(0, 1));
}

TEST(MatchPersons, OneWhoWalksFromOneSensorsViewIntoAnothersStaysOne) {
  const Path path = [](double t) { return Vector3d(-2.0 + 0.8 * t, 1.0, 0.0); };
  EXPECT_THAT(persons_of({seen(0, path, 0.0, 2.5), seen(1, path, 2.45, 5.0)}), ElementsAre(0, 0));
  EXPECT_THAT(persons_of({seen(0, path, 0.0, 2.5), seen(1, path, 3.0, 5.0)}), ElementsAre(0, 0));
}

TEST(MatchPersons, TheNearerOfTwoFollowersIsTheSame) {
  const std::vector<Tracklet> tracklets{seen(0, standing(0.0), 0.0, 5.0), seen(0, standing(0.5), 5.5, 8.0),
                                        seen(0, standing(0.1), 5.5, 9.0)};
  EXPECT_THAT(persons_of(tracklets), ElementsAre(0, 1, 0));
}

TEST(MatchPersons, TwoOfOneSensorAtOneTimeAreTwoHoweverNear) {
  EXPECT_THAT(persons_of({seen(0, standing(0.0), 0.0, 5.0), seen(0, standing(0.1), 1.0, 3.0)}),
              ElementsAre(0, 1));
}

TEST(MatchPersons, AGhostOfThreeFramesDoesNotTakeAnothersPlace) {
  const Path path = standing(0.0);
  const std::vector<Tracklet> tracklets{seen(0, path, 0.0, 5.0), seen(1, standing(0.2), 2.0, 2.09),
                                        seen(1, path, 0.0, 5.0), seen(2, standing(-1.8), 3.0, 3.09),
                                        seen(2, path, 0.0, 5.0)};
  EXPECT_THAT(persons_of(tracklets), ElementsAre(0, 1, 0, 2, 0));
}

TEST(MatchPersons, APersonWhomOnlyOneSensorSeesIsAPerson) {
  const std::vector<Tracklet> tracklets{seen(2, standing(1.5), 0.0, 3.0), seen(0, standing(0.0), 0.0, 5.0),
                                        seen(1, standing(0.0), 0.0, 5.0)};
  const PersonMatch match = match_persons(tracklets, {});
  EXPECT_EQ(match.persons, 2u);
  EXPECT_THAT(match.person_of_tracklet, ElementsAre(1, 0, 0));
}

TEST(MatchPersons, TheOrderOfTrackletsDoesNotMatter) {
  const Path left = [](double t) { return Vector3d(-0.45, 1.0, 0.4 * std::sin(t)); };
  const Path right = [](double t) { return Vector3d(0.45, 1.0, -0.4 * std::sin(t)); };
  std::vector<Tracklet> tracklets;
  for (std::size_t s = 0; s < 3; ++s) {
    const double change_s = 2.0 + static_cast<double>(s);
    tracklets.push_back(seen(s, left, 0.0, change_s));
    tracklets.push_back(seen(s, left, change_s + 0.5, 9.0));
    tracklets.push_back(seen(s, right, 0.5, 8.0));
  }
  const std::vector<std::size_t> persons = persons_of(tracklets);
  EXPECT_THAT(persons, ElementsAre(0, 0, 1, 0, 0, 1, 0, 0, 1));
  for (std::size_t turn = 1; turn < tracklets.size(); ++turn) {
    std::vector<Tracklet> turned = tracklets;
    std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(turn), turned.end());
    std::vector<std::size_t> expected = persons;
    std::rotate(expected.begin(), expected.begin() + static_cast<std::ptrdiff_t>(turn), expected.end());
    EXPECT_EQ(persons_of(turned), expected) << "turned by " << turn;
  }
}

TEST(MatchPersons, NothingIsNobodyAndOneFrameIsSomebody) {
  EXPECT_EQ(match_persons({}, {}).persons, 0u);
  EXPECT_THAT(persons_of({seen(0, standing(0.0), 0.0, 0.01)}), ElementsAre(0));
}

TEST(MatchPersons, ATrackletHasAPlaceForEachOfItsRisingTimes) {
  EXPECT_THROW((void)persons_of({Tracklet{}}), InternalError);
  EXPECT_THROW((void)persons_of({Tracklet{0, {1, 2}, {Vector3d::Zero()}}}), InternalError);
  EXPECT_THROW((void)persons_of({Tracklet{0, {2, 2}, {Vector3d::Zero(), Vector3d::Zero()}}}), InternalError);
}

}  // namespace
}  // namespace trilat
