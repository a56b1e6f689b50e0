// SPDX-License-Identifier: MIT
// A sensor's joints tell the unit of their positions, holes, and the order of the joints in the file.
#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/session/body_readings.h"
#include "tests/datasets/made_session.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using BodyChange = std::function<void(Body&)>;

JointFaults faults_of(const BodyChange& change, int bodies = 40) {
  JointFaults faults;
  for (int i = 0; i < bodies; ++i) {
    Body body = standing_body();
    change(body);
    faults.add(body);
  }
  return faults;
}

std::string text_of(const BodyChange& change, int bodies = 40) {
  const JointFaults faults = faults_of(change, bodies);
  return faults.out_of_reach_text().value_or("") + faults.misread_text().value_or("");
}

void exchange(Body& body, Joint a, Joint b) {
  std::swap(body.position_m[static_cast<std::size_t>(a)], body.position_m[static_cast<std::size_t>(b)]);
}

BodyChange exchanged(const std::vector<std::pair<Joint, Joint>>& pairs) {
  return [=](Body& body) {
    for (const auto& [a, b] : pairs) exchange(body, a, b);
  };
}

BodyChange scaled(float by) {
  return [=](Body& body) {
    for (auto& at : body.position_m)
      for (float& axis : at) axis *= by;
  };
}

void reverse(Body& body) { std::ranges::reverse(body.position_m); }

TEST(JointFaults, ASoundPersonOfAnySizeHasNone) {
  EXPECT_EQ(text_of([](Body&) {}), "");
  for (const float size : {0.5F, 0.9F, 1.0F, 1.15F})
    EXPECT_EQ(text_of([=](Body& body) {
                for (auto& at : body.position_m) at = {at[0] * size, at[1] * size, at[2]};
              }),
              "");
  EXPECT_EQ(text_of([](Body& body) {  // two joints that the sensor does not see, put anywhere
              body.position_m[6] = {3, 0, 2.5F};
              body.position_m[15] = {3, 0, 2.5F};
            }),
            "");
}

TEST(JointFaults, BodiesOfWhichNoJointIsSeenAreNamed) {
  const BodyChange unseen = [](Body& body) { body.position_m.fill({}), body.tracking_state.fill(0); };
  EXPECT_EQ(text_of(unseen),
            "none of 40 bodies has a joint that is tracked or inferred: write 2 for joints that are");
  EXPECT_EQ(text_of(unseen, 29), "");
  EXPECT_EQ(text_of([](Body& body) { body.tracking_state.fill(0), body.tracking_state[3] = 1; }), "");
}

TEST(JointFaults, JointsBehindTheSensorAreNamed) {
  const auto behind = [](std::size_t joints) {
    return text_of([=](Body& body) {
      for (std::size_t j = 0; j < joints; ++j) body.position_m[j][2] *= -1.0F;
    });
  };
  EXPECT_THAT(behind(kJointCount), HasSubstr("joints lie behind the sensor, at negative z"));
  EXPECT_THAT(behind(23), HasSubstr("joints lie behind the sensor, at negative z"));
  EXPECT_THAT(behind(22), testing::Not(HasSubstr("behind the sensor")));
}

// The position of a joint that is not tracked says nothing, however far from the other joints it lies.
// Each axis by its factor.
BodyChange turned(float x, float y, float z) {
  return [=](Body& body) {
    for (auto& at : body.position_m) at = {at[0] * x, at[1] * y, (at[2] - 2.5F) * z + 2.5F};
  };
}

TEST(JointFaults, PersonsOnTheirHeadsAreNamedByTheAxesThatWereTurned) {
  EXPECT_EQ(faults_of(turned(1, 1, 1)).upside_down_text(), std::nullopt);
  EXPECT_EQ(faults_of(turned(1, -1, 1)).upside_down_text(),
            "heads lie below the feet: does y point down? A Kinect's points up");
  EXPECT_EQ(faults_of(turned(-1, -1, 1)).upside_down_text(),
            "heads lie below the feet: does y point down, and x to the other side? A Kinect's points up");
  EXPECT_EQ(faults_of(turned(1, -1, 1), 14).upside_down_text(), std::nullopt) << "28 feet are too few";
  JointFaults some;
  for (int i = 0; i < 40; ++i) {
    Body body = standing_body();
    if (i % 5 < 3) turned(1, -1, 1)(body);
    some.add(body);
  }
  EXPECT_EQ(some.upside_down_text(), std::nullopt) << "three of five are not all";
  const JointFaults footless = faults_of([](Body& body) {
    turned(-1, -1, 1)(body);
    for (const Joint joint : {Joint::foot_left, Joint::foot_right})
      body.tracking_state[static_cast<std::size_t>(joint)] = 0;
  });
  EXPECT_EQ(footless.upside_down_text(), "heads lie below the feet: does y point down? A Kinect's points up")
      << "without feet nothing is known of x";
}

TEST(JointFaults, FeetPointBackwardsUnderExchangedSidesAndMirroredAxes) {
  std::vector<std::pair<Joint, Joint>> sides;
  for (std::size_t j = 0; j < kJointCount; ++j)
    if (const auto joint = static_cast<Joint>(j); mirror_of(joint) > joint)
      sides.emplace_back(joint, mirror_of(joint));
  for (const BodyChange& change : {turned(-1, 1, 1), turned(1, -1, 1), turned(1, 1, -1), exchanged(sides)})
    EXPECT_EQ(faults_of(change).backward_feet(), 1.0);
  EXPECT_EQ(faults_of(turned(1, 1, 1)).backward_feet(), 0.0);
  EXPECT_EQ(faults_of(turned(-1, 1, -1)).backward_feet(), 0.0) << "a person seen from behind";
  EXPECT_EQ(faults_of(turned(-1, 1, 1), 14).backward_feet(), std::nullopt) << "28 feet are too few";
  JointFaults faults;
  for (int i = 0; i < 100; ++i) {
    Body body = standing_body();
    if (i < 30) turned(-1, 1, 1)(body);
    faults.add(body);
  }
  EXPECT_EQ(faults.backward_feet(), 0.3);
}

TEST(JointFaults, FeetAreNamedWhereThoseOfAllSensorsPointBackwards) {
  EXPECT_EQ(backward_feet_text({}), std::nullopt);
  EXPECT_EQ(backward_feet_text(std::array{0.69}), std::nullopt);
  EXPECT_EQ(backward_feet_text(std::array{0.98, 1.0, 0.4}), std::nullopt)
      << "two sensors are behind the person";
  EXPECT_THAT(backward_feet_text(std::array{0.9}).value_or(""),
              HasSubstr("90 % of the bodies: is the sensor behind the person, are left and right"));
  EXPECT_THAT(
      backward_feet_text(std::array{1.0, 0.7}).value_or(""),
      HasSubstr("feet point backwards in 70 % of the bodies: are left and right exchanged, or is an axis"));
}

TEST(JointFaults, FeetThatAreNotSeenTellNothing) {
  const JointFaults faults = faults_of([](Body& body) {
    turned(-1, -1, 1)(body);
    for (const Joint joint : {Joint::ankle_left, Joint::ankle_right})
      body.tracking_state[static_cast<std::size_t>(joint)] = 0;
  });
  EXPECT_EQ(faults.upside_down_text(), std::nullopt);
  EXPECT_EQ(faults.backward_feet(), std::nullopt);
}

TEST(JointFaults, BonesToJointsThatAreNotSeenDoNotCount) {
  EXPECT_EQ(text_of([](Body& body) {
              for (const Joint joint : {Joint::spine_mid, Joint::elbow_left, Joint::elbow_right,
                                        Joint::knee_left, Joint::knee_right, Joint::spine_shoulder}) {
                body.position_m[static_cast<std::size_t>(joint)] = {3.0F, 3.0F, 3.0F};
                body.tracking_state[static_cast<std::size_t>(joint)] = 0;
              }
            }),
            "");
}

TEST(JointFaults, PositionsInAnotherUnitAreNamedByIt) {
  EXPECT_EQ(text_of(scaled(1000.0F)),
            "1000 of 1000 joints lie farther than 10 m of the sensor and count as not seen; taken as "
            "millimetres they are within its reach: write positions in metres");
  EXPECT_THAT(text_of(scaled(100.0F)), HasSubstr("; taken as centimetres they are within its reach"));
  // Nine in ten are enough, and no fewer: a tenth may be holes.
  const auto with_holes = [](std::size_t holes) {
    return [=](Body& body) {
      scaled(1000.0F)(body);
      for (std::size_t j = 0; j < holes; ++j) body.position_m[j] = {};
    };
  };
  EXPECT_THAT(text_of(with_holes(2)), HasSubstr("millimetres"));
  EXPECT_THAT(text_of(with_holes(3)), testing::Not(HasSubstr("millimetres")));
}

TEST(JointFaults, JointsAtTheSensorAreNamedAsHoles) {
  const auto at = [](std::array<float, 3> hand, std::array<float, 3> foot) {
    return [=](Body& body) {
      body.position_m[7] = hand;
      body.position_m[15] = foot;
    };
  };
  EXPECT_EQ(
      text_of(at({}, {}), 5),
      "10 joints lie nearer than 0.4 m or farther than 10 m of the sensor (hand_left 5, foot_left 5) and "
      "count as not seen; all of them at (0, 0, 0), as is written for joints without a position");
  EXPECT_THAT(text_of(at({}, {0, 0, 10.1F}), 5), HasSubstr("; 5 of them at (0, 0, 0), as is written"));
  EXPECT_THAT(text_of(at({0, 0, 0.39F}, {0, 0, 10.1F}), 5), testing::EndsWith("and count as not seen"));
  EXPECT_EQ(text_of(at({0, 0, 0.41F}, {0, 0, 9.9F}), 5), "");
}

TEST(JointFaults, JointsInAnotherOrderAreNamedByTheirBones) {
  using enum Joint;
  const BodyChange inserted = [](Body& body) {  // spine_shoulder after spine_mid, from the hips upwards
    const auto first = body.position_m.begin();
    std::rotate(first + 2, first + 20, first + 21);
  };
  const BodyChange shifted = [](Body& body) {
    std::rotate(body.position_m.begin(), body.position_m.begin() + 1, body.position_m.end());
  };
  const BodyChange hands_at_knees = exchanged({{wrist_left, knee_left}, {wrist_right, knee_right}});
  for (const BodyChange& change : {exchanged({{shoulder_left, hip_left}, {shoulder_right, hip_right}}),
                                   hands_at_knees, inserted, shifted, BodyChange(reverse)}) {
    EXPECT_THAT(text_of(change), testing::EndsWith("are the joints in the order of a Kinect v2?"));
    EXPECT_TRUE(faults_of(change).misread_text().has_value());
  }
  EXPECT_THAT(
      text_of(hands_at_knees),
      HasSubstr("10 of 24 bones are longer than those of a person (elbow_left to wrist_left 0.97 m, at "
                "most 0.45; "));
  EXPECT_EQ(text_of(reverse, 29), "");
  EXPECT_NE(text_of(reverse, 30), "");
  EXPECT_THAT(text_of([](Body& body) { reverse(body), body.tracking_state.fill(0); }),
              testing::StartsWith("none of 40 bodies"));
}

// All bones alike: the unit, not the order.
TEST(JointFaults, BodiesOfAnotherSizeThanAPersonsAreNamedByIt) {
  const auto sized = [](float by) {
    return text_of([=](Body& body) {
      for (auto& at : body.position_m) at = {by * at[0], by * at[1], at[2]};
    });
  };
  EXPECT_EQ(sized(3.28084F),
            "bones are some 3 times as long as those of a person of 1.7 m; taken as feet positions are a "
            "person's: write "
            "them in metres");
  EXPECT_THAT(sized(2.0F), testing::EndsWith("are positions in metres?"));
  EXPECT_THAT(sized(0.3048F),
              testing::EndsWith("times as long as those of a person of 1.7 m; are positions in metres?"));
  EXPECT_EQ(sized(1.45F).find("as long as those of a person of 1.7 m"), std::string::npos);
  EXPECT_EQ(sized(0.55F), "");
}

// Six bones that are too long are a fault; up to four are a hidden limb.
TEST(JointFaults, ALimbThatIsTooLongIsNoOtherOrder) {
  const auto longer = [](std::size_t joints) {
    return [=](Body& body) {  // hands and feet, each at the end of a bone of its own
      constexpr std::array<std::size_t, 6> kEnds{7, 11, 15, 19, 22, 24};
      for (std::size_t k = 0; k < joints; ++k)
        body.position_m[kEnds[k]][2] = 3.5F + 0.1F * static_cast<float>(k);
    };
  };
  EXPECT_EQ(text_of(longer(2)), "");
  EXPECT_NE(text_of(longer(6)), "");
}

TEST(JointFaults, AJointThatIsWrittenInTwoPlacesIsNamed) {
  using enum Joint;
  const auto copied = [](Joint from, Joint to, int every = 1) {
    return [=, n = std::make_shared<int>(0)](Body& body) {
      if (++*n % every == 0)
        body.position_m[static_cast<std::size_t>(to)] = body.position_m[static_cast<std::size_t>(from)];
    };
  };
  EXPECT_EQ(text_of(copied(shoulder_left, elbow_left)),
            "elbow_left has the position of shoulder_left, to the last bit: was one of them written twice?");
  for (const auto& [from, to] : {std::pair{hip_right, knee_right}, std::pair{knee_left, ankle_left},
                                 std::pair{elbow_right, wrist_right}, std::pair{neck, head}})
    EXPECT_THAT(text_of(copied(from, to)),
                HasSubstr(std::string(name_of(to)) + " has the position of " + std::string(name_of(from))));
  EXPECT_THAT(text_of(copied(wrist_left, wrist_right)),
              HasSubstr("wrist_right has the position of wrist_left"));
  EXPECT_TRUE(faults_of(copied(neck, head)).misread_text().has_value());
  EXPECT_EQ(text_of(copied(wrist_left, thumb_left)), "");  // no joint of the tables
  EXPECT_EQ(text_of(copied(shoulder_left, elbow_left, 2)), "");
  EXPECT_EQ(text_of(copied(shoulder_left, elbow_left), 29), "");
}

TEST(JointFaults, ExchangedJointsOfTheSpineAreNamed) {
  using enum Joint;
  EXPECT_EQ(text_of(exchanged({{neck, head}})),
            "neck lies farther from spine_shoulder than head does: are the two exchanged?");
  EXPECT_THAT(text_of(exchanged({{spine_shoulder, neck}})),
              HasSubstr("spine_shoulder lies farther from spine_mid than neck does"));
  EXPECT_THAT(text_of(exchanged({{spine_mid, spine_shoulder}})),
              HasSubstr("spine_mid lies farther from spine_base than spine_shoulder does"));
  EXPECT_TRUE(faults_of(exchanged({{neck, head}})).misread_text().has_value());
  EXPECT_EQ(text_of(exchanged({{neck, head}}), 29), "");
  EXPECT_NE(text_of(exchanged({{neck, head}}), 30), "");
}

// A tracker that is wrong in a part of the frames has its joints in order.
TEST(JointFaults, ASpineThatIsSometimesExchangedIsNotNamed) {
  const auto of_every = [](int sound) {
    JointFaults faults;
    for (int i = 0; i < 100; ++i) {
      Body body = standing_body();
      if (i >= sound) exchange(body, Joint::neck, Joint::head);
      faults.add(body);
    }
    return faults.misread_text().has_value();
  };
  EXPECT_FALSE(of_every(11));
  EXPECT_TRUE(of_every(10));
}

}  // namespace
}  // namespace trilat
