// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace trilat {

// What only the simulator knows about the participant in one frame of one sensor.
struct TrackerTruth {
  std::int64_t sequence = 0;      // the frame's
  std::uint32_t hidden = 0;       // bit j: joint j (of the person, not of the body) is in view but hidden
  bool exchanged = false;         // the body's left and right are the person's right and left
  std::uint64_t tracking_id = 0;  // of the participant's body; 0 when there is none
  bool operator==(const TrackerTruth&) const = default;
};

// tracker_truth.h5, format 1. Has its final name once finished.
class TrackerTruthWriter {
 public:
  TrackerTruthWriter(const std::filesystem::path& path, const std::vector<std::string>& sensors);
  ~TrackerTruthWriter();
  // A sensor's frames in rising order.
  void append(std::size_t sensor, const TrackerTruth& truth);
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Refuses what the writer does not write, with the place in the file.
class TrackerTruthReader {
 public:
  explicit TrackerTruthReader(const std::filesystem::path& path);
  ~TrackerTruthReader();
  const std::vector<std::string>& sensors() const;  // sorted
  std::uint64_t frames(const std::string& sensor) const;
  std::vector<TrackerTruth> read(const std::string& sensor, std::uint64_t first, std::uint64_t count) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace trilat
