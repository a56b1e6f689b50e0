// SPDX-License-Identifier: MIT
// Truth that lies elsewhere than what the sensors see, by its frame, its start, its rate or its axes.
#include "tests/pipeline/error_cells.h"
#include "tests/pipeline/spoiled_takes.h"

namespace trilat {
namespace {

using namespace spoiled;
using testing::HasSubstr;

// The whole rig in another world than the export's.
Spoil world_changed(double turn_rad, const Eigen::Vector3d& shift_m) {
  return calibrated([=](Calibration& c) {
    const RigidTransform change{Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitY())),
                                shift_m};
    for (SensorPose& sensor : c.sensors) sensor.world_from_sensor = change * sensor.world_from_sensor;
  });
}

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
      const std::string notes = notes_of(execute_study(study, recorded.campaign, folder / "results", {}));
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
  expect_one_note(notes_of(execute_study(study_of(kMean), recorded.campaign, folder / "results", {})), said);
}

INSTANTIATE_TEST_SUITE_P(All, MisplacedTruth, testing::ValuesIn(all_misplaced()),
                         [](const auto& misplaced) { return misplaced.param.what; });

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

// The errors are those of the take before it was laid on its side.
TEST(UpAxis, ATruthWithZUpGivesTheSameErrors) {
  const ScratchFolder folder;
  const StudySpec study = study_of(kMean);
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
  const ResultsSummary summary = execute_study(study_of(kMean), recorded.campaign, folder / "results", {});
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

}  // namespace
}  // namespace trilat
