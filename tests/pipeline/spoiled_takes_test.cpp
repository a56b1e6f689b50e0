// SPDX-License-Identifier: MIT
// Recordings that would give wrong numbers: each is named, with its size and what to do; sound ones are not.
#include "tests/pipeline/spoiled_takes.h"

#include "tests/support/trials.h"

namespace trilat {
namespace {

using namespace spoiled;

Spoil scaled(double times, const std::string& asset = "") {
  return [=](Recorded& recorded) {
    change_export(recorded, [&](const auto& assets, auto& rows) {
      for (auto& row : rows)
        for (std::size_t c = 2; c < row.size(); ++c)
          if (!row[c].empty() && assets[c].starts_with(asset))
            row[c] = fmt::format("{:.6f}", times * std::stod(row[c]));
    });
  };
}

void hold_every_fourth(Recorded& recorded) {
  change_export(recorded, [](const auto&, auto& rows) {
    for (std::size_t r = 0; r < rows.size(); ++r)
      std::copy(rows[r - r % 4].begin() + 2, rows[r - r % 4].end(), rows[r].begin() + 2);
  });
}

Spoil exchanged(Joint one, Joint other) {
  return [=](Recorded& recorded) {
    JointMapping mapping = read_mapping(recorded.take().mapping);
    const auto assets_of = [&](Joint joint) -> std::vector<std::string>& {
      return std::ranges::find(mapping.joints, joint, &JointMapping::Entry::joint)->assets;
    };
    std::swap(assets_of(one), assets_of(other));
    write_mapping(recorded.take().mapping, mapping);
  };
}

// The joints in another order: from the hips to the head, then the arms and the legs.
void reorder_joints(BodyPositions& joints) {
  std::rotate(joints.begin() + 2, joints.begin() + 20, joints.begin() + 21);
}

void exchange_neck_and_head(BodyPositions& joints) {
  std::swap(joints[static_cast<std::size_t>(Joint::neck)], joints[static_cast<std::size_t>(Joint::head)]);
}

Spoil bodies_scaled(float by) {
  return bodies([by](BodyPositions& joints) {
    for (auto& position_m : joints)
      for (float& axis_m : position_m) axis_m *= by;
  });
}

// Poses of cameras whose own axes have other signs than a Kinect's.
Spoil with_axes(const Eigen::Vector3d& signs) {
  return calibrated([signs](Calibration& c) {
    for (SensorPose& sensor : c.sensors) {
      Eigen::Quaterniond& rotation = sensor.world_from_sensor.rotation;
      rotation = Eigen::Quaterniond(rotation.toRotationMatrix() * signs.asDiagonal());
    }
  });
}

void put_bodies_in_the_world(Recorded& recorded) {
  const Calibration calibration = read_calibration(recorded.take().calibration);
  change_frames(recorded, [&](std::size_t s, BodyFrame& frame) {
    for (Body& body : frame.bodies)
      for (auto& at : body.position_m) {
        Eigen::Map<Eigen::Vector3f> at_m(at.data());
        at_m = (calibration.sensors[s].world_from_sensor * at_m.cast<double>()).cast<float>();
      }
  });
}

void set_the_clock_of_arrivals(Recorded& recorded) {
  change_frames(recorded, [](std::size_t sensor, BodyFrame& frame) {
    if (sensor == 1 && frame.stamp.sequence > 150) frame.stamp.arrival_ns += 4'000'000'000;
  });
}

void keep_every_fourth_frame(Recorded& recorded) {
  change_session(recorded.take(), recorded.folder / "spoiled.h5",
                 {[](std::size_t, BodyFrame& frame) { return frame.stamp.sequence % 4 == 0; }});
}

void mirror_export(Recorded& recorded) {
  change_export(recorded, [](const auto&, auto& rows) {
    for (auto& row : rows)
      for (std::size_t c = 4; c < row.size(); c += 3)
        if (!row[c].empty()) row[c] = fmt::format("{:.6f}", -std::stod(row[c]));
  });
}

void cut_export(Recorded& recorded) {
  change_export(recorded, [](const auto&, auto& rows) { rows.resize(rows.size() / 2); });
}

void copy_k1_to_k2(Recorded& recorded) {
  const SessionReader session(recorded.take().session);
  const std::vector<BodyFrame> k1 = session.body_frames(0, 0, session.counts(0).body_frames);
  std::size_t next = 0;
  change_session(recorded.take(), recorded.folder / "spoiled.h5", {[&](std::size_t s, BodyFrame& frame) {
                   if (s != 1) return true;
                   if (next == k1.size()) return false;
                   frame = k1[next++];
                   return true;
                 }});
}

// The points of one frame of an export by asset, without those that are missing.
using ExportPoints = std::map<std::string, Eigen::Vector3d>;

// Applies `change` to the points of each frame; `frame` is the frame's number.
Spoil points(const std::function<void(ExportPoints& points_m, std::size_t frame)>& change) {
  return [=](Recorded& recorded) {
    change_export(recorded, [&](const auto& assets, auto& rows) {
      for (std::size_t r = 0; r < rows.size(); ++r) {
        ExportPoints points_m;
        for (std::size_t c = 2; c + 2 < rows[r].size(); c += 3)
          if (!rows[r][c].empty())
            points_m[assets[c]] = {std::stod(rows[r][c]), std::stod(rows[r][c + 1]),
                                   std::stod(rows[r][c + 2])};
        change(points_m, r);
        for (std::size_t c = 2; c + 2 < rows[r].size(); c += 3)
          for (int axis = 0; axis < 3; ++axis)
            rows[r][c + static_cast<std::size_t>(axis)] =
                points_m.contains(assets[c]) ? fmt::format("{:.6f}", points_m[assets[c]][axis]) : "";
      }
    });
  };
}

Eigen::Vector3d middle_of_shoulders(const ExportPoints& points_m) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const auto& [asset, at_m] : points_m)
    if (asset.starts_with("shoulder_")) sum_m += at_m, count += 1.0;
  return sum_m / count;
}

Spoil relative_to_shoulders(const Eigen::Vector3d& axes) {
  return points([=](ExportPoints& points_m, std::size_t) {
    const Eigen::Vector3d root_m = middle_of_shoulders(points_m).cwiseProduct(axes);
    for (auto& [asset, at_m] : points_m) at_m -= root_m;
  });
}

// Each asset of the mapping under the joint after its own.
void map_one_joint_off(Recorded& recorded) {
  JointMapping mapping = read_mapping(recorded.take().mapping);
  std::vector<std::string> first = mapping.joints.front().assets;
  for (std::size_t j = 0; j + 1 < mapping.joints.size(); ++j)
    mapping.joints[j].assets = mapping.joints[j + 1].assets;
  mapping.joints.back().assets = first;
  write_mapping(recorded.take().mapping, mapping);
}

void run_backwards(Recorded& recorded) {
  change_export(recorded, [](const auto&, auto& rows) {
    auto turned = rows;
    std::ranges::reverse(turned);
    for (std::size_t r = 0; r < rows.size(); ++r)
      std::copy(turned[r].begin() + 2, turned[r].end(), rows[r].begin() + 2);
  });
}

struct Spoiled {
  std::string what;
  Spoil spoil;
  std::vector<std::string> said;  // parts of one note
};

std::vector<Spoiled> all_spoiled() {
  const auto turn = [](float degrees) {
    return Eigen::AngleAxisf(degrees * static_cast<float>(M_PI) / 180.0f, Eigen::Vector3f::UnitY());
  };
  return {
      {"sound", [](Recorded&) {}, {}},
      {"feet", scaled(3.28084), {"mocap.csv", "3.28084 times as large as the sensors", "as feet", "unit"}},
      {"wrist_in_feet", scaled(3.28084, "wrist_left"), {"mocap.csv", "moves wrist_left 3.", "unit"}},
      {"wrists_exchanged",
       exchanged(Joint::wrist_left, Joint::wrist_right),
       {"mapping.json", "has wrist_left and wrist_right exchanged", "mend the mapping"}},
      {"wrist_and_elbow_exchanged",
       exchanged(Joint::wrist_left, Joint::elbow_left),
       {"mapping.json", "has elbow_left and wrist_left exchanged"}},
      {"held_poses", hold_every_fourth, {"mocap.csv", "in 75 % of its frames", "true rate is 25 %"}},
      {"late_clock", delayed(2, 300), {"k3 shows movements 0.3", "s later than the others", "\"sensors\""}},
      {"joint_at_origin",
       joint_put(0, Joint::wrist_left, {0.0F, 0.0F, 0.0F}),
       {"k1: ", "joints lie nearer than 0.4 m or farther than 10 m", "wrist_left "}},
      {"joint_far_away",
       joint_put(0, Joint::wrist_left, {0.0F, 0.0F, 1e8F}),
       {"k1: ", "joints lie nearer than 0.4 m or farther than 10 m", "wrist_left "}},
      {"jumping_body", jump_to_another, {"k2: 2 times a body moves more than 1 m"}},
      {"reordered_joints",
       bodies(reorder_joints),
       {"k1: ", "bones are longer than those of a person", "in the order of a Kinect v2?"}},
      {"neck_and_head",
       bodies(exchange_neck_and_head),
       {"k1, k2, k3, k4: neck lies farther from spine_shoulder than head does: are the two exchanged?"}},
      {"z_of_other_sign",
       bodies([](BodyPositions& joints) {
         for (auto& at : joints) at[2] = -at[2];
       }),
       {"k1, k2, k3, k4: joints lie behind the sensor, at negative z"}},
      {"elbows_at_shoulders",
       bodies([](BodyPositions& joints) {
         for (const auto& [shoulder, elbow] : {std::pair{Joint::shoulder_left, Joint::elbow_left},
                                               std::pair{Joint::shoulder_right, Joint::elbow_right}})
           joints[static_cast<std::size_t>(elbow)] = joints[static_cast<std::size_t>(shoulder)];
       }),
       {"k1, k2, k3, k4: elbow_left has the position of shoulder_left, to the last bit"}},
      {"clock_of_arrivals",
       set_the_clock_of_arrivals,
       {"k2: arrivals jump by 4.0", "while its ticks go on", "take 4.0", " s from the arrivals"}},
      {"bodies_in_feet",
       bodies_scaled(3.28084F),
       {"spoiled.h5: k",
        "times as long as those of a person of 1.7 m; taken as feet positions are a person's"}},
      {"bodies_too_small", bodies_scaled(0.3048F), {"spoiled.h5: k", "; are positions in metres?"}},
      {"bodies_in_world",
       put_bodies_in_the_world,
       {"spoiled.h5: ", "has bodies that lie in the world already", "falls from", "in its own frame"}},
      {"slow_frames",
       keep_every_fourth_frame,
       {"k1, k2: frames are 0.13 s apart, and sensor_gap_s is 0.11 s", "\"sensor_gap_s\": 0.2"}},
      {"relative_truth",
       relative_to_shoulders({1, 1, 1}),
       {"mocap.csv",
        "gives positions relative to the middle of shoulder_left and shoulder_right: put right"}},
      {"relative_but_for_heights",
       relative_to_shoulders({1, 0, 1}),
       {"mocap.csv",
        "relative to the middle of shoulder_left and shoulder_right, but for heights: put right"}},
      {"one_axis_of_the_truth",
       points([](ExportPoints& points_m, std::size_t) {
         for (auto& [asset, at_m] : points_m) at_m.x() *= 0.6;
       }),
       {"mocap.csv", "has x 0.6", "times as large as the sensors see it", "divide its x by 0.6"}},
      {"mapped_one_joint_off",
       map_one_joint_off,
       {"mapping.json", "has points under the names of others: ", "mend the mapping"}},
      {"moved_truth",
       points([](ExportPoints& points_m, std::size_t frame) {
         for (auto& [asset, at_m] : points_m) at_m.z() += frame < 500 ? 0.0 : 0.6;
       }),
       {"mocap.csv", "from 5.0", "another frame than what the sensors see, shifted by", "-0.6"}},
      {"empty_truth",
       points([](ExportPoints& points_m, std::size_t) { points_m.clear(); }),
       {"mocap.csv", "has frames from 0.0", "while the session runs, but no joint in any of them"}},
      {"mirrored_truth", mirror_export, {"mocap.csv", "is mirrored", "right-handed axes"}},
      {"cut_export", cut_export, {"mocap.csv", "frames where its header promises", "was it cut?"}},
      {"inverse_poses",
       calibrated([](Calibration& c) {
         for (SensorPose& sensor : c.sensors) sensor.world_from_sensor = sensor.world_from_sensor.inverse();
       }),
       {"calibration.json", "has poses from the world to the sensor, as OpenCV gives them, it seems",
        "wanted are the inverse", "falls from"}},
      {"z_up",
       calibrated([](Calibration& c) {
         const Eigen::Quaterniond up(Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitX()));
         for (SensorPose& sensor : c.sensors)
           sensor.world_from_sensor = RigidTransform{up, {0.0, 0.0, 0.0}} * sensor.world_from_sensor;
       }),
       {"calibration.json", "has z up, it seems: the person stands along z"}},
      {"w_first",
       calibrated([](Calibration& c) {
         for (SensorPose& sensor : c.sensors) {
           Eigen::Quaterniond& q = sensor.world_from_sensor.rotation;
           q = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y());
         }
       }),
       {"calibration.json", "has quaternions in the order w, x, y, z, it seems; wanted are x, y, z, w"}},
      {"camera_axes",
       with_axes({-1.0, -1.0, 1.0}),
       {"calibration.json", "has a camera's axes, it seems; wanted are x to the sensor's left, y up",
        "put right"}},
      {"axes_of_opengl",
       with_axes({-1.0, 1.0, -1.0}),
       {"calibration.json", "has a camera's axes, it seems; wanted are x to the sensor's left, y up",
        "falls from"}},
      {"bodies_in_camera_axes",
       bodies([](BodyPositions& joints) {
         for (auto& at : joints) at = {-at[0], -at[1], at[2]};
       }),
       {"spoiled.h5: all sensors see the person", "with x, y, z of all bodies read as (-x, -y, z), put right",
        "Write the bodies so"}},
      {"bodies_with_y_down",
       bodies([](BodyPositions& joints) {
         for (auto& at : joints) at[1] = -at[1];
       }),
       {"spoiled.h5: k1, k2, k3, k4: heads lie below the feet: does y point down? A Kinect's"}},
      {"bodies_upside_down",
       bodies([](BodyPositions& joints) {
         for (auto& at : joints) at[1] = -at[1];
       }),
       {"spoiled.h5: all sensors see the person ", "with x, y, z of all bodies read as (",
        "Write the bodies so"}},
      {"bodies_mirrored",
       bodies([](BodyPositions& joints) {
         for (auto& at : joints) at[0] = -at[0];
       }),
       {"spoiled.h5: all sensors see the person as in a mirror", "read as (-x, y, z)",
        "Record without mirroring"}},
      {"bodies_with_exchanged_sides",
       bodies([](BodyPositions& joints) {
         for (std::size_t j = 0; j < kJointCount; ++j)
           if (const Joint other = mirror_of(static_cast<Joint>(j)); other > static_cast<Joint>(j))
             std::swap(joints[j], joints[static_cast<std::size_t>(other)]);
       }),
       {"spoiled.h5: all sensors: feet point backwards in ", "are left and right exchanged"}},
      {"large_calibration",
       calibrated([](Calibration& c) {
         for (SensorPose& sensor : c.sensors) sensor.world_from_sensor.translation_m *= 1.05;
       }),
       {"calibration.json", "places the sensors too far apart: all measure 4.", "% too short"}},
      {"exchanged_poses",
       calibrated(
           [](Calibration& c) { std::swap(c.sensors[0].world_from_sensor, c.sensors[1].world_from_sensor); }),
       {"calibration.json", "has the poses of k1 and k2 exchanged"}},
      {"turned_sensor",
       calibrated([&](Calibration& c) {
         c.sensors[1].world_from_sensor.rotation =
             turn(12.0f).cast<double>() * c.sensors[1].world_from_sensor.rotation;
       }),
       {"calibration.json", "k2 sees the person 0.", "from where the others do"}},
      {"long_ranges",
       tracked(1, [](Eigen::Vector3f& point, std::size_t) { point *= 1.1f; }),
       {"k2 measures", "% too long", "metres"}},
      {"mirrored",
       tracked(2, [](Eigen::Vector3f& point, std::size_t) { point.x() = -point.x(); }),
       {"k3 sees the person as in a mirror"}},
      {"pushed_sensor",
       tracked(1,
               [=](Eigen::Vector3f& point, std::size_t frame) {
                 if (frame > 150) point = turn(8.0f) * point;
               }),
       {"k2 moved during the take", "pushed"}},
      {"same_stream", copy_k1_to_k2, {"k1 and k2 hold the same bodies"}},
  };
}

// Without motion capture: what the sensors show of each other.
std::vector<Spoiled> all_spoiled_poses() {
  return {
      {"sound", [](Recorded&) {}, {}},
      {"exchanged",
       calibrated(
           [](Calibration& c) { std::swap(c.sensors[0].world_from_sensor, c.sensors[1].world_from_sensor); }),
       {"calibration.json", "has the poses of k1 and k2 exchanged"}},
      {"turned",
       calibrated([](Calibration& c) {
         c.sensors[1].world_from_sensor.rotation =
             Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY())) *
             c.sensors[1].world_from_sensor.rotation;
       }),
       {"calibration.json", "k2 sees the person ", "from where the others do"}},
      {"displaced",
       calibrated([](Calibration& c) { c.sensors[2].world_from_sensor.translation_m.x() += 0.8; }),
       {"calibration.json", "k3 sees the person 0.8", "from where the others do"}},
  };
}

class SpoiledTakes : public testing::TestWithParam<Spoiled> {};

TEST_P(SpoiledTakes, AreNamedWithSizeAndRemedy) {
  const ScratchFolder folder;
  Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
  GetParam().spoil(recorded);
  expect_one_note(
      notes_of(execute_study(study_of(kMeanOfStatedClock), recorded.campaign, folder / "results", {})),
      GetParam().said);
}

INSTANTIATE_TEST_SUITE_P(All, SpoiledTakes, testing::ValuesIn(all_spoiled()),
                         [](const auto& spoiled) { return spoiled.param.what; });

// It looks mirrored, and is not.
TEST(SpoiledTruth, AMotionRunBackwardsIsNotCalledMirrored) {
  const ScratchFolder folder;
  Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
  run_backwards(recorded);
  const std::string notes =
      notes_of(execute_study(study_of(kMeanOfStatedClock), recorded.campaign, folder / "results", {}));
  EXPECT_THAT(notes, testing::Not(testing::HasSubstr("mirror")));
}

class SpoiledPoses : public testing::TestWithParam<Spoiled> {};

TEST_P(SpoiledPoses, AreNamedWithoutMotionCapture) {
  const ScratchFolder folder;
  Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
  GetParam().spoil(recorded);
  recorded.take().mocap.clear();
  recorded.take().mapping.clear();
  const ResultsSummary summary = execute_study(study_of(kMean), recorded.campaign, folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 0u);
  expect_one_note(notes_of(summary), GetParam().said);
}

INSTANTIATE_TEST_SUITE_P(All, SpoiledPoses, testing::ValuesIn(all_spoiled_poses()),
                         [](const auto& spoiled) { return spoiled.param.what; });

// 200 takes of different rigs, activities and trackers' noise: hardly one is taken for spoiled.
TEST(SoundTakes, AreHardlyEverNamed) {
  const ScratchFolder folder;
  const SimulationSpec usual = parse_simulation(
      parse_json(R"({"format": "trilat.simulation", "version": 1, "body_tracker": {}})", "usual"), "usual",
      {});
  std::size_t takes = 0, named = 0;
  std::string all;
  for (std::uint64_t k = 0; k < trials(20); ++k) {
    SimulationSpec spec = walking_spec(10, k % 3 == 0 ? 4.0 : 8.0);
    spec.seed = 100 + k;
    spec.body_tracker = usual.body_tracker;
    constexpr std::array kActivities{Activity::walking, Activity::arm_swing, Activity::leg_crossing,
                                     Activity::standing};
    spec.activities[0].activity = kActivities.at(k % 4);
    if (k % 4 == 2)
      spec.activities[0].marker_joints = {Joint::hip_left,   Joint::hip_right,  Joint::knee_left,
                                          Joint::knee_right, Joint::ankle_left, Joint::ankle_right};
    spec.rig.heights_m.clear();
    for (std::uint64_t s = 0; s < 2 + k % 5; ++s)
      spec.rig.heights_m.push_back(0.5 + 0.37 * static_cast<double>((3 * s + k) % 5));
    spec.rig.arc_rad = (k % 2 == 0 ? 2.0 : 1.0) * M_PI;
    spec.rig.rotation_sigma_rad = k % 4 == 1 ? 0.0 : 0.5 * M_PI / 180.0;
    spec.rig.position_sigma_m = 0.005;
    const std::string name = fmt::format("c{}", k);
    const std::string notes = notes_of(execute_study(
        study_of(kMeanOfStatedClock), simulate_into(folder / name, spec), folder / (name + "r"), {}));
    takes += 10;
    named += static_cast<std::size_t>(std::ranges::count(notes, '\n'));
    all += notes;
  }
  EXPECT_EQ(takes, 10 * trials(20));
  EXPECT_LE(static_cast<double>(named) / static_cast<double>(takes), 0.01 + slack(0.01, takes)) << all;
}

}  // namespace
}  // namespace trilat
