// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/results/take_errors.h"

namespace trilat {

// Joints, methods and truths of take.h5, the axes of its samples. Each track holds one slot for every
// instant, joint and method, whether the method answered or not. A track is what estimates are held against:
// the mocap, or a left-out sensor.
struct TakeHead {
  std::string id, condition;  // condition: the take's activity
  std::uint64_t instants = 0;
  std::vector<std::string> joints, methods, tracks;
  std::vector<std::string> status_names;  // status number -> name
  bool is_upright = false;                // y is up, so that a trunk's inclination means something
  std::vector<std::array<double, 3>> track_position_m = {};  // of left-out sensors, one a track
};

// Whether a status of that name, as a take's head lists them, is an answer.
inline bool is_answer(std::string_view status) {
  return status == "converged" || status == "closed_form" || status == "clamped" || status == "given";
}

// Rows [first_instant, first_instant + instants) of a track. Per instant: time_ns and heading_rad; per
// instant and joint: truth (x, y, z); per instant, joint and method: everything else, joints before methods.
struct SampleBlock {
  std::uint64_t first_instant = 0;
  std::uint64_t instants = 0;
  std::vector<std::int64_t> time_ns;  // host clock
  std::vector<float> heading_rad;     // of the person, from world +z towards +x; NaN when not known
  std::vector<double> truth_m;        // NaN where there is none
  std::vector<float> estimate_m;      // x, y, z; NaN where there is none
  std::vector<std::uint8_t> status;
  std::vector<std::uint32_t> iterations;
  std::vector<float> cost_m2;
  std::vector<float> gdop;
  std::vector<float> sigma_m;        // an axis, of the method's own model; NaN without one; not stored
  std::vector<std::uint8_t> ranges;  // how many sensors saw the joint (per instant and joint)
  // How many of them saw it occluded: inferred, or crossed by a limb in front (per instant and joint).
  std::vector<std::uint8_t> occluded;

  // Sizes every column and fills it with what says "nothing happened": NaN, zero, status 0.
  void reset(std::uint64_t first, std::uint64_t count, std::size_t joints, std::size_t methods);
};

// Which columns of a block to read; errors: without ranges, cost and GDOP, which are empty then.
enum class SampleColumns { errors, all };

// take.h5 (version 4), the item of a take: its samples and their errors. Equal takes give equal bytes. The
// blocks of a track are written in the order of time; what is never written must be written empty.
class StoredTake {
 public:
  static constexpr const char* kName = "take.h5";

  static StoredTake create(const std::filesystem::path& path, const TakeHead& head);
  static StoredTake open(const std::filesystem::path& path);
  StoredTake(StoredTake&&) noexcept;
  ~StoredTake();

  const std::filesystem::path& path() const;
  const TakeHead& head() const;

  void write(std::size_t track, const SampleBlock& block);
  SampleBlock read(std::size_t track, std::uint64_t first_instant, std::uint64_t instants,
                   SampleColumns columns) const;
  // Reads into the memory of an earlier block.
  void read(std::size_t track, std::uint64_t first_instant, std::uint64_t instants, SampleColumns columns,
            SampleBlock& block) const;

  void write_errors(const TakeErrors& errors);
  TakeErrors read_errors() const;

  // Closes a file that was created, with all of it on the disk; OutputError when that cannot be.
  void finish();

 private:
  StoredTake();
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace trilat
