// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace trilat {

// The shape of one take's samples: every instant has a slot for every joint and method, whether answered or
// not.
struct TakeShape {
  std::string id;
  std::uint64_t instants = 0;
  std::string condition{};  // its activity
};

// What every take of a results folder shares.
struct SamplesHeader {
  std::vector<std::string> joints;
  std::vector<std::string> methods;
  std::vector<std::string> status_names;  // status number -> name
  std::string alignment;                  // that of the error column
  double training_share = 0.0;            // what it was learnt on, where it is learnt
  std::vector<TakeShape> takes;
};

// Rows [first_instant, first_instant + instants) of one take. Per instant: time_ns and heading_rad; per
// instant and joint: truth (x, y, z); per instant, joint and method: everything else, joints before methods.
struct SampleBlock {
  std::uint64_t first_instant = 0;
  std::uint64_t instants = 0;
  std::vector<std::int64_t> time_ns;  // host clock
  std::vector<float> heading_rad;     // of the person, from world +z towards +x; NaN when not known
  std::vector<double> truth_m;        // NaN where there is none
  std::vector<double> estimate_m;     // x, y, z; NaN where there is none
  std::vector<std::uint8_t> status;
  std::vector<std::uint32_t> iterations;
  std::vector<double> cost_m2;
  std::vector<float> gdop;
  std::vector<std::uint8_t> ranges;  // how many sensors saw the joint (per instant and joint)
  // How many of them saw it occluded: inferred, or crossed by a limb in front (per instant and joint).
  std::vector<std::uint8_t> occluded;

  // Sizes every column and fills it with what says "nothing happened": NaN, zero, status 0.
  void reset(std::uint64_t first, std::uint64_t count, std::size_t joints, std::size_t methods);
};

// Which columns of a block to read: positions are time, heading, truth, occluded, estimate and status; the
// others are empty then.
enum class SampleColumns { positions, all };

// samples.h5 (version 2). Written slot by slot: blocks may come in any order and from any thread, the bytes
// are the same. All space is laid out when the file is made; what is never written must be written empty.
class SamplesFile {
 public:
  static SamplesFile create(const std::filesystem::path& path, const SamplesHeader& header);
  static SamplesFile open(const std::filesystem::path& path);
  SamplesFile(SamplesFile&&) noexcept;
  ~SamplesFile();

  const std::filesystem::path& path() const;
  const SamplesHeader& header() const;
  void write(std::size_t take, const SampleBlock& block);
  // Closes a file that was created, with all of it on the disk; OutputError when that cannot be.
  void finish();
  // x, y, z of estimate - truth after alignment; joints before methods. Metres.
  void write_errors(std::size_t take, std::uint64_t first_instant, std::span<const float> error_m);
  SampleBlock read(std::size_t take, std::uint64_t first_instant, std::uint64_t instants,
                   SampleColumns columns = SampleColumns::all) const;
  // The same into the memory of an earlier block.
  void read(std::size_t take, std::uint64_t first_instant, std::uint64_t instants, SampleColumns columns,
            SampleBlock& block) const;
  std::vector<float> read_errors(std::size_t take, std::uint64_t first_instant, std::uint64_t instants) const;

 private:
  SamplesFile();
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace trilat
