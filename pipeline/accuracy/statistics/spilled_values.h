// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <span>
#include <vector>

namespace trilat {

// Numbers in groups, as many as there are: those that do not fit into memory lie in a file without a name,
// which is gone when the process is. In a group they are in no order.
class SpilledValues {
 public:
  // `folder`: of the file, should there be one. `threads`: that write at the same time.
  SpilledValues(std::size_t groups, std::filesystem::path folder, std::uint64_t memory_bytes,
                std::size_t threads);
  ~SpilledValues();
  SpilledValues(const SpilledValues&) = delete;
  SpilledValues& operator=(const SpilledValues&) = delete;

  // Adds values from one thread.
  class Writer {
   public:
    explicit Writer(SpilledValues& values) : values_(values), buffers_(values.groups_.size()) {}
    void add(std::size_t group, double value) {
      std::vector<double>& buffer = buffers_[group];
      if (buffer.capacity() == 0) buffer.reserve(values_.chunk_);
      buffer.push_back(value);
      if (buffer.size() == values_.chunk_) values_.store(group, buffer);
    }
    // What was added is there from now on; OutputError when the disk is full.
    void finish();

   private:
    SpilledValues& values_;
    std::vector<std::vector<double>> buffers_;
  };

  // Calls see(span of values) until all of the group have been shown. From any thread.
  template <class See>
  void visit(std::size_t group, const See& see) const {
    for (const std::vector<double>& kept : groups_[group].kept) see(std::span<const double>(kept));
    std::vector<double> values;
    for (const Extent& extent : groups_[group].spilled) {
      read(extent, values);
      see(std::span<const double>(values));
    }
  }

 private:
  struct Extent {
    std::uint64_t first = 0, count = 0;  // of the file, in values
  };
  struct Group {
    std::vector<std::vector<double>> kept;
    std::vector<Extent> spilled;
  };
  void store(std::size_t group, std::vector<double>& buffer);
  void spill(const Extent& extent, const std::vector<double>& buffer);
  void read(const Extent& extent, std::vector<double>& values) const;

  std::filesystem::path folder_;
  std::size_t chunk_;           // values that are stored together
  std::uint64_t may_keep_ = 0;  // values
  std::uint64_t in_file_ = 0;   // values
  int file_ = -1;
  std::mutex mutex_;
  std::vector<Group> groups_;
};

}  // namespace trilat
