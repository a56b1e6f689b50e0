// SPDX-License-Identifier: MIT
// Simulated takes with one fault put into their files, and what a study says of them.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/rig/calibration.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/rewritten_session.h"
#include "tests/support/scratch.h"

namespace trilat::spoiled {

// A made campaign of one take, and what is done to it.
struct Recorded {
  Campaign campaign;
  std::filesystem::path folder;
  Take& take() { return campaign.takes[0]; }
};
using Spoil = std::function<void(Recorded&)>;

inline std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream text(line);
  for (std::string field; std::getline(text, field, ',');) fields.push_back(field);
  if (line.ends_with(',')) fields.emplace_back();
  return fields;
}

// Row by row: `change` sees a frame's fields, and the frames before it as they were.
inline void change_export(Recorded& recorded,
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

inline Spoil calibrated(const std::function<void(Calibration&)>& change) {
  return [=](Recorded& recorded) {
    Calibration calibration = read_calibration(recorded.take().calibration);
    change(calibration);
    write_calibration(recorded.take().calibration, calibration);
  };
}

// `change` of every body frame that is stored of the sensors.
inline void change_frames(Recorded& recorded,
                          const std::function<void(std::size_t sensor, BodyFrame& frame)>& change) {
  change_session(recorded.take(), recorded.folder / "spoiled.h5", {[&](std::size_t sensor, BodyFrame& frame) {
                   change(sensor, frame);
                   return true;
                 }});
}

using BodyPositions = std::array<std::array<float, 3>, kJointCount>;
// `change` of the joints of every body of all sensors.
inline Spoil bodies(const std::function<void(BodyPositions&)>& change) {
  return [=](Recorded& recorded) {
    change_frames(recorded, [&](std::size_t, BodyFrame& frame) {
      for (Body& body : frame.bodies) change(body.position_m);
    });
  };
}

// Of one sensor, what its tracker delivers.
inline Spoil tracked(std::size_t sensor,
                     const std::function<void(Eigen::Vector3f&, std::size_t frame)>& change) {
  return [=](Recorded& recorded) {
    std::size_t count = 0;
    change_frames(recorded, [&](std::size_t s, BodyFrame& frame) {
      if (s != sensor) return;
      for (Body& body : frame.bodies)
        for (auto& position_m : body.position_m) {
          Eigen::Vector3f point(position_m.data());
          change(point, count);
          Eigen::Map<Eigen::Vector3f>(position_m.data()) = point;
        }
      ++count;
    });
  };
}

// Puts one joint at a fixed place and calls it tracked, as drivers write joints that they did not see.
inline Spoil joint_put(std::size_t sensor, Joint joint, std::array<float, 3> where_m) {
  return [=](Recorded& recorded) {
    change_frames(recorded, [=](std::size_t s, BodyFrame& frame) {
      if (s != sensor || frame.stamp.sequence < 60 || frame.stamp.sequence >= 120) return;
      for (Body& body : frame.bodies) {
        body.position_m[static_cast<std::size_t>(joint)] = where_m;
        body.tracking_state[static_cast<std::size_t>(joint)] = 2;
      }
    });
  };
}

// For a second one sensor gives another person under the same tracking id.
inline void jump_to_another(Recorded& recorded) {
  change_frames(recorded, [](std::size_t s, BodyFrame& frame) {
    if (s != 1 || frame.stamp.sequence < 60 || frame.stamp.sequence >= 90) return;
    for (Body& body : frame.bodies)
      for (auto& position_m : body.position_m) position_m[0] += 1.5F;
  });
}

inline Spoil delayed(std::size_t sensor, std::int64_t ms) {
  return [=](Recorded& recorded) {
    change_frames(recorded, [=](std::size_t s, BodyFrame& frame) {
      if (s != sensor) return;
      frame.stamp.device_ticks += 10'000 * ms;  // of 100 ns
      frame.stamp.arrival_ns += 1'000'000 * ms;
    });
  };
}

inline SimulationSpec recorded_spec(std::uint64_t seed = 5) {
  SimulationSpec spec = walking_spec(1, 10.0);
  spec.seed = seed;
  spec.sensor.free_running = false;  // so that a stream can be put in the place of another
  return spec;
}

// The notes of a study, with a line each.
inline std::string notes_of(const ResultsSummary& summary) {
  std::string text;
  for (const TakeNote& note : summary.notes) text += note.place + ": " + note.text + "\n";
  return text;
}

inline constexpr const char* kMeanOfStatedClock =
    R"("alignments": ["rigid"], "clock": "stated", "methods": [{"method": "mean"}])";
inline constexpr const char* kMean = R"("alignments": ["none"], "methods": [{"method": "mean"}])";

inline void expect_one_note(const std::string& notes, const std::vector<std::string>& said) {
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

}  // namespace trilat::spoiled
