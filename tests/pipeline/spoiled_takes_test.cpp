// SPDX-License-Identifier: MIT
// Recordings that would give wrong numbers: each is named, with its size and what to do; sound ones are not.
#include <cmath>
#include <functional>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/rig/calibration.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/error_cells.h"
#include "tests/pipeline/rewritten_session.h"
#include "tests/support/scratch.h"
#include "tests/support/trials.h"

namespace trilat {
namespace {

using testing::HasSubstr;

// A made campaign of one take, and what is done to it.
struct Recorded {
  Campaign campaign;
  std::filesystem::path folder;
  Take& take() { return campaign.takes[0]; }
};
using Spoil = std::function<void(Recorded&)>;

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream text(line);
  for (std::string field; std::getline(text, field, ',');) fields.push_back(field);
  if (line.ends_with(',')) fields.emplace_back();
  return fields;
}

// Row by row: `change` sees a frame's fields, and the frames before it as they were.
void change_export(Recorded& recorded,
                   const std::function<void(const std::vector<std::string>& assets,
                                            std::vector<std::vector<std::string>>& rows)>& change) {
  std::istringstream text(read_file(recorded.take().mocap));
  std::string head, line;
  std::vector<std::string> assets;
  while (std::getline(text, line) && !line.starts_with("Frame,")) {
    if (line.starts_with(",Name,")) assets = fields_of(line);
    head += line + '\n';
  }
  head += line + '\n';
  std::vector<std::vector<std::string>> rows;
  while (std::getline(text, line)) rows.push_back(fields_of(line));
  change(assets, rows);
  for (const auto& row : rows) head += fmt::format("{}\n", fmt::join(row, ","));
  write_file(recorded.take().mocap, head);
}

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

void lay_on_the_side(Recorded& recorded) {
  recorded.take().up_axis.reset();  // a simulated take states it
  change_export(recorded, [](const auto&, auto& rows) {
    for (auto& row : rows)
      for (std::size_t c = 2; c + 2 < row.size(); c += 3) {
        if (row[c].empty()) continue;
        const std::string height = row[c + 1];
        row[c + 1] = fmt::format("{:.6f}", -std::stod(row[c + 2]));
        row[c + 2] = height;
      }
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

Spoil calibrated(const std::function<void(Calibration&)>& change) {
  return [=](Recorded& recorded) {
    Calibration calibration = read_calibration(recorded.take().calibration);
    change(calibration);
    write_calibration(recorded.take().calibration, calibration);
  };
}

// Of one sensor, what its tracker delivers.
Spoil tracked(std::size_t sensor, const std::function<void(Eigen::Vector3f&, std::size_t frame)>& change) {
  return [=](Recorded& recorded) {
    std::size_t count = 0;
    change_session(recorded.take(), recorded.folder / "spoiled.h5", {[&](std::size_t s, BodyFrame& frame) {
                     if (s != sensor) return true;
                     for (Body& body : frame.bodies)
                       for (auto& position_m : body.position_m) {
                         Eigen::Map<Eigen::Vector3f> map(position_m.data());
                         Eigen::Vector3f point = map;
                         change(point, count);
                         map = point;
                       }
                     ++count;
                     return true;
                   }});
  };
}

Spoil delayed(std::size_t sensor, std::int64_t ms) {
  return [=](Recorded& recorded) {
    change_session(recorded.take(), recorded.folder / "spoiled.h5", {[=](std::size_t s, BodyFrame& frame) {
                     if (s != sensor) return true;
                     frame.stamp.device_ticks += 10'000 * ms;  // of 100 ns
                     frame.stamp.arrival_ns += 1'000'000 * ms;
                     return true;
                   }});
  };
}

// As drivers and converters write joints that were not seen: (0, 0, 0) and "tracked"; or some number.
Spoil joint_put(std::size_t sensor, Joint joint, std::array<float, 3> where_m) {
  return [=](Recorded& recorded) {
    change_session(recorded.take(), recorded.folder / "spoiled.h5", {[=](std::size_t s, BodyFrame& frame) {
                     if (s != sensor || frame.stamp.sequence < 60 || frame.stamp.sequence >= 120) return true;
                     for (Body& body : frame.bodies) {
                       body.position_m[static_cast<std::size_t>(joint)] = where_m;
                       body.tracking_state[static_cast<std::size_t>(joint)] = 2;
                     }
                     return true;
                   }});
  };
}

// For a second one sensor gives another person under the same tracking id.
void jump_to_another(Recorded& recorded) {
  change_session(recorded.take(), recorded.folder / "spoiled.h5", {[](std::size_t s, BodyFrame& frame) {
                   if (s != 1 || frame.stamp.sequence < 60 || frame.stamp.sequence >= 90) return true;
                   for (Body& body : frame.bodies)
                     for (auto& position_m : body.position_m) position_m[0] += 1.5F;
                   return true;
                 }});
}

// All sensors give the joints in another order: from the hips to the head, then the arms and the legs.
void reorder_joints(Recorded& recorded) {
  change_session(recorded.take(), recorded.folder / "spoiled.h5", {[](std::size_t, BodyFrame& frame) {
                   for (Body& body : frame.bodies) {
                     const auto first = body.position_m.begin();
                     std::rotate(first + 2, first + 20, first + 21);
                   }
                   return true;
                 }});
}

// Positions so many times as large, of all sensors.
Spoil bodies_scaled(float by) {
  return [by](Recorded& recorded) {
    change_session(recorded.take(), recorded.folder / "spoiled.h5", {[by](std::size_t, BodyFrame& frame) {
                     for (Body& body : frame.bodies)
                       for (auto& position_m : body.position_m)
                         for (float& axis_m : position_m) axis_m *= by;
                     return true;
                   }});
  };
}

// The whole rig in another world than the export's.
Spoil world_changed(double turn_rad, const Eigen::Vector3d& shift_m) {
  return calibrated([=](Calibration& c) {
    const RigidTransform change{Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitY())),
                                shift_m};
    for (SensorPose& sensor : c.sensors) sensor.world_from_sensor = change * sensor.world_from_sensor;
  });
}

void put_bodies_in_the_world(Recorded& recorded) {
  const Calibration calibration = read_calibration(recorded.take().calibration);
  change_session(recorded.take(), recorded.folder / "spoiled.h5", {[&](std::size_t s, BodyFrame& frame) {
                   for (Body& body : frame.bodies)
                     for (auto& at : body.position_m) {
                       Eigen::Map<Eigen::Vector3f> at_m(at.data());
                       at_m = (calibration.sensors[s].world_from_sensor * at_m.cast<double>()).cast<float>();
                     }
                   return true;
                 }});
}

void exchange_neck_and_head(Recorded& recorded) {
  change_session(recorded.take(), recorded.folder / "spoiled.h5", {[](std::size_t, BodyFrame& frame) {
                   for (Body& body : frame.bodies)
                     std::swap(body.position_m[static_cast<std::size_t>(Joint::neck)],
                               body.position_m[static_cast<std::size_t>(Joint::head)]);
                   return true;
                 }});
}

void set_the_clock_of_arrivals(Recorded& recorded) {
  change_session(recorded.take(), recorded.folder / "spoiled.h5", {[](std::size_t sensor, BodyFrame& frame) {
                   if (sensor == 1 && frame.stamp.sequence > 150) frame.stamp.arrival_ns += 4'000'000'000;
                   return true;
                 }});
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

SimulationSpec recorded_spec(std::uint64_t seed = 5) {
  SimulationSpec spec = walking_spec(1, 10.0);
  spec.seed = seed;
  spec.sensor.free_running = false;  // so that a stream can be put in the place of another
  return spec;
}

// The notes of an evaluation, with a line each.
std::string notes_of(const Campaign& campaign, const std::filesystem::path& results) {
  const StudySpec study =
      study_of(R"("alignments": ["rigid"], "clock": "stated", "methods": [{"method": "mean"}])");
  std::string text;
  for (const TakeNote& note : execute_study(study, campaign, results, {}).notes)
    text += note.place + ": " + note.text + "\n";
  return text;
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
       reorder_joints,
       {"k1: ", "bones are longer than those of a person", "in the order of a Kinect v2?"}},
      {"neck_and_head",
       exchange_neck_and_head,
       {"k1, k2, k3, k4: neck lies farther from spine_shoulder than head does: are the two exchanged?"}},
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

void expect_one_note(const std::string& notes, const std::vector<std::string>& said) {
  if (said.empty()) {
    EXPECT_EQ(notes, "");
    return;
  }
  std::istringstream lines(notes);
  std::vector<std::string> with_all;
  for (std::string line; std::getline(lines, line);)
    if (std::ranges::all_of(said,
                            [&](const std::string& part) { return line.find(part) != std::string::npos; }))
      with_all.push_back(line);
  EXPECT_EQ(with_all.size(), 1u) << notes;
}

class SpoiledTakes : public testing::TestWithParam<Spoiled> {};

TEST_P(SpoiledTakes, AreNamedWithSizeAndRemedy) {
  const ScratchFolder folder;
  Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
  GetParam().spoil(recorded);
  expect_one_note(notes_of(recorded.campaign, folder / "results"), GetParam().said);
}

INSTANTIATE_TEST_SUITE_P(All, SpoiledTakes, testing::ValuesIn(all_spoiled()),
                         [](const auto& spoiled) { return spoiled.param.what; });

// Somebody who walks in a circle, in a world that is turned, is where they were some seconds before or after.
TEST(SpoiledWorlds, ARigOutsideTheExportsWorldIsNoWrongStart) {
  struct World {
    double turn_rad;
    Eigen::Vector3d shift_m;
    std::string said;
  };
  for (const World& world :
       {World{1.57, {0.0, 0.0, 0.0}, "has other axes than what the sensors see, read as \\(z, y, -x\\)"},
        World{-0.5,
              {0.6, 0.0, 0.0},
              "lies in another frame .*turned by -?(29|30) degrees about y and shifted .*calibrate the "
              "sensors in its world"},
        World{0.0,
              {0.0, -0.9, 0.0},
              "lies in another frame .*shifted by \\(-?0.0., -?0.9., -?0.0.\\) m.*calibrate the sensors in "
              "its world"},
        World{0.0,
              {1.2, 0.0, 0.4},
              "lies in another frame .*shifted by \\(-?1.2., -?0.0., -?0.4.\\) m.*calibrate the sensors in "
              "its world"}})
    for (const std::string clock : {"check", "stated", "motion"}) {
      const ScratchFolder folder;
      Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
      world_changed(world.turn_rad, world.shift_m)(recorded);
      const StudySpec study =
          study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}], "clock": ")" + clock + '"');
      std::string notes;
      for (const TakeNote& note : execute_study(study, recorded.campaign, folder / "results", {}).notes)
        notes += note.place + ": " + note.text + "\n";
      EXPECT_THAT(notes, testing::ContainsRegex("mocap.csv: " + world.said)) << clock;
      EXPECT_THAT(notes, testing::Not(testing::HasSubstr("mocap_start_host_ns"))) << clock;
    }
}

Spoil started_s(double later_s) {
  return [=](Recorded& recorded) {
    recorded.take().mocap_start_host_ns += static_cast<std::int64_t>(later_s * 1e9);
  };
}

// Every `step`-th frame of an export of 100 Hz, under another rate.
Spoil exported_at(double stated_hz, std::size_t step) {
  return [=](Recorded& recorded) {
    std::size_t frames = 0;
    change_export(recorded, [&](const auto&, auto& rows) {
      frames = rows.size();
      std::vector<std::vector<std::string>> kept;
      for (std::size_t r = 0; r < rows.size(); r += step) {
        kept.push_back(rows[r]);
        kept.back()[0] = std::to_string(r / step);
        kept.back()[1] = fmt::format("{:.6f}", static_cast<double>(r / step) / stated_hz);
      }
      rows = kept;
    });
    std::string text = read_file(recorded.take().mocap);
    const auto replace_all = [&](const std::string& old, const std::string& with) {
      for (auto at = text.find(old); at != std::string::npos; at = text.find(old, at + with.size()))
        text.replace(at, old.size(), with);
    };
    replace_all("Rate,100.000000", fmt::format("Rate,{:.6f}", stated_hz));
    for (const char* key : {"Frames in Take,", "Exported Frames,"})
      replace_all(key + std::to_string(frames), key + std::to_string((frames + step - 1) / step));
    write_file(recorded.take().mocap, text);
  };
}

struct Misplaced {
  std::string what;
  Activity activity;
  double duration_s;
  Spoil spoil;
  std::vector<std::string> said;
};

// Places that the motion does not tell: too little of it is in both.
std::vector<Misplaced> all_misplaced() {
  const std::vector<std::string> apart{"mocap.csv: lies 0.", "m from where the sensors see the joints",
                                       "is mocap_start_host_ns right, and the calibration in its world?"};
  const auto moved = calibrated([](Calibration& c) {
    for (SensorPose& sensor : c.sensors) sensor.world_from_sensor.translation_m.x() += 0.7;
  });
  const auto raised = [](Recorded& recorded) {
    change_export(recorded, [](const auto&, auto& rows) {
      for (auto& row : rows)
        for (std::size_t c = 3; c < row.size(); c += 3)
          if (!row[c].empty()) row[c] = fmt::format("{:.6f}", std::stod(row[c]) + 0.5);
    });
  };
  return {
      {"sound", Activity::walking, 30.0, [](Recorded&) {}, {}},
      {"rate_120_for_100",
       Activity::walking,
       30.0,
       exported_at(120.0, 1),
       {"mocap.csv: runs 1.2", "times as fast as the sensors see the person move",
        "rate of 100 Hz, where 120 Hz"}},
      {"every_second_frame",
       Activity::walking,
       30.0,
       exported_at(100.0, 2),
       {"mocap.csv: runs 2.0", "times as fast", "rate of 50 Hz, where 100 Hz"}},
      {"standing", Activity::standing, 10.0, [](Recorded&) {}, {}},
      {"four_seconds_late",
       Activity::walking,
       30.0,
       started_s(4.0),
       {"mocap.csv: starts ", " s earlier than stated, or starts 4.",
        "later than stated, by the motion, which does not", "write \"mocap_start_host_ns\": "}},
      {"late_start", Activity::walking, 30.0, started_s(20.0), apart},
      {"early_start", Activity::walking, 30.0, started_s(-20.0), apart},
      {"late_start_of_a_short_take", Activity::walking, 6.0, started_s(5.0), apart},
      {"moved_calibration",
       Activity::standing,
       10.0,
       moved,
       {"mocap.csv: lies in another frame", "shifted by (0.70, "}},
      {"raised_truth",
       Activity::standing,
       10.0,
       raised,
       {"mocap.csv: lies in another frame", "shifted by (0.00, -0.5"}},
      {"hardly_covered", Activity::walking, 30.0, started_s(20.0), {"has truth for 10.0 s of the 30.0 s"}}};
}

class MisplacedTruth : public testing::TestWithParam<Misplaced> {};

TEST_P(MisplacedTruth, IsNamedWithItsDistance) {
  const ScratchFolder folder;
  const auto& [what, activity, duration_s, spoil, said] = GetParam();
  SimulationSpec spec = walking_spec(1, duration_s);
  spec.activities[0].activity = activity;
  spec.body_tracker = default_body_tracker();
  Recorded recorded{simulate_into(folder / "campaign", spec), folder.path()};
  spoil(recorded);
  const StudySpec study = study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}])");
  std::string notes;
  for (const TakeNote& note : execute_study(study, recorded.campaign, folder / "results", {}).notes)
    notes += note.place + ": " + note.text + "\n";
  expect_one_note(notes, said);
}

INSTANTIATE_TEST_SUITE_P(All, MisplacedTruth, testing::ValuesIn(all_misplaced()),
                         [](const auto& misplaced) { return misplaced.param.what; });

TEST(SpoiledSensors, OfThreeTheMirroredOneIsNamedAndNoOther) {
  const ScratchFolder folder;
  SimulationSpec spec = recorded_spec();
  spec.rig.heights_m.resize(3);
  Recorded recorded{simulate_into(folder / "campaign", spec), folder.path()};
  tracked(1, [](Eigen::Vector3f& point, std::size_t) { point.x() = -point.x(); })(recorded);
  const std::string notes = notes_of(recorded.campaign, folder / "results");
  expect_one_note(notes, {"k2 sees the person as in a mirror"});
  EXPECT_THAT(notes, testing::Not(testing::ContainsRegex("(k1|k3) sees")));
}

class SpoiledPoses : public testing::TestWithParam<Spoiled> {};

TEST_P(SpoiledPoses, AreNamedWithoutMotionCapture) {
  const ScratchFolder folder;
  Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
  GetParam().spoil(recorded);
  recorded.take().mocap.clear();
  recorded.take().mapping.clear();
  const ResultsSummary summary =
      execute_study(study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}])"), recorded.campaign,
                    folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 0u);
  std::string notes;
  for (const TakeNote& note : summary.notes) notes += note.place + ": " + note.text + "\n";
  expect_one_note(notes, GetParam().said);
}

INSTANTIATE_TEST_SUITE_P(All, SpoiledPoses, testing::ValuesIn(all_spoiled_poses()),
                         [](const auto& spoiled) { return spoiled.param.what; });

class LateClocks : public testing::TestWithParam<int> {};

// Also where the joints correlate well without shifting; and not the sensor's pose is blamed.
TEST_P(LateClocks, AreNamedWithTheirOffset) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(1, 34.0);
  spec.body_tracker = default_body_tracker();
  Recorded recorded{simulate_into(folder / "campaign", spec), folder.path()};
  delayed(1, GetParam())(recorded);
  const std::string notes = notes_of(recorded.campaign, folder / "results");
  const std::string about = "k2 shows movements ";
  const std::size_t at = notes.find(about);
  ASSERT_NE(at, std::string::npos) << notes;
  EXPECT_NEAR(std::stod(notes.substr(at + about.size())), 1e-3 * GetParam(), 0.03) << notes;
  EXPECT_EQ(notes.find("by the pose it has"), std::string::npos) << notes;
  EXPECT_EQ(std::ranges::count(notes, '\n'), 1) << notes;
}

INSTANTIATE_TEST_SUITE_P(Milliseconds, LateClocks, testing::Values(120, 150, 200, 300, 500, 800));

// Taken as the same person, that second would put the mean a third of a metre off.
TEST(SpoiledSensors, ABodyThatJumpsToAnotherPersonIsNotTaken) {
  const ScratchFolder folder;
  Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
  const StudySpec study = study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}])");
  const double sound_m = error_cells(execute_study(study, recorded.campaign, folder / "sound", {}))[0].max_m;
  jump_to_another(recorded);
  EXPECT_LT(error_cells(execute_study(study, recorded.campaign, folder / "jumping", {}))[0].max_m,
            sound_m + 0.1);
}

TEST(SpoiledSensors, AJointAtTheSensorIsNotTaken) {
  const ScratchFolder folder;
  Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
  const StudySpec study =
      study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}, {"method": "range_bearing"}])");
  joint_put(0, Joint::wrist_left, {0.0F, 0.0F, 1e8F})(recorded);
  const ResultsSummary summary = execute_study(study, recorded.campaign, folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 0u);
  for (const ErrorCell& cell : error_cells(summary)) {
    if (cell.group == kAverageGroup) continue;
    EXPECT_LT(cell.max_m, 0.5) << cell.method << " " << cell.group;
  }
}

// The errors are those of the take before it was laid on its side.
TEST(UpAxis, ATruthWithZUpGivesTheSameErrors) {
  const ScratchFolder folder;
  const StudySpec study = study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}])");
  Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
  const double upright_m =
      error_cells(execute_study(study, recorded.campaign, folder / "upright", {}))[0].mae_m;
  lay_on_the_side(recorded);
  const auto error_m = [&](UpAxis axis) {
    recorded.take().up_axis = axis;
    const std::string name = fmt::format("axis{}", static_cast<int>(axis));
    return error_cells(execute_study(study, recorded.campaign, folder / name, {}))[0].mae_m;
  };
  EXPECT_NEAR(error_m(UpAxis::z), upright_m, 1e-5);  // an export has six digits
  EXPECT_GT(error_m(UpAxis::y), 1.0);
  recorded.take().up_axis.reset();
  EXPECT_THAT(message_of([&] { execute_study(study, recorded.campaign, folder / "unstated", {}); }),
              HasSubstr("stands along z, and y is taken as up: state \"up_axis\": \"z\""));
}

TEST(UpAxis, ATakeThatShowsNothingIsTakenAsY) {
  const ScratchFolder folder;
  Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
  recorded.take().up_axis.reset();
  JointMapping mapping = read_mapping(recorded.take().mapping);
  std::erase_if(mapping.joints, [](const auto& entry) { return entry.joint != Joint::wrist_left; });
  recorded.take().mapping = folder / "wrist.json";
  write_mapping(folder / "wrist.json", mapping);
  const ResultsSummary summary =
      execute_study(study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}])"), recorded.campaign,
                    folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 0u);
}

TEST(UpAxis, IsToldByHowAPersonStands) {
  UpAxisEstimator standing, lying, unknown;
  standing.add(Joint::head, {0.1, 0.0, 1.7});
  standing.add(Joint::shoulder_left, {0.0, 0.2, 1.4});
  standing.add(Joint::shoulder_right, {0.0, -0.2, 1.4});
  EXPECT_EQ(standing.axis(), UpAxis::z);
  lying.add(Joint::head, {0.0, 0.1, 0.1});
  lying.add(Joint::ankle_left, {1.6, 0.1, 0.1});
  EXPECT_FALSE(lying.axis());
  unknown.add(Joint::wrist_left, {0.0, 1.0, 0.0});
  unknown.add(Joint::elbow_left, {0.0, 1.3, 0.0});
  EXPECT_FALSE(unknown.axis());
  unknown.add(Joint::head, Eigen::Vector3d::Constant(kNaN));
  EXPECT_FALSE(unknown.axis());
}

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
    const std::string notes = notes_of(simulate_into(folder / name, spec), folder / (name + "r"));
    takes += 10;
    named += static_cast<std::size_t>(std::ranges::count(notes, '\n'));
    all += notes;
  }
  EXPECT_EQ(takes, 10 * trials(20));
  EXPECT_LE(static_cast<double>(named) / static_cast<double>(takes), 0.01 + slack(0.01, takes)) << all;
}

}  // namespace
}  // namespace trilat
