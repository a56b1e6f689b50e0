// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/errors/condition_errors.h"
#include "pipeline/errors/track_samples.h"

namespace trilat {
namespace {

// The columns of pairs: a method on the samples that another answers, too. Equal columns are one.
struct PairColumns {
  std::vector<SampleColumn> columns;
  std::vector<std::pair<std::size_t, std::size_t>> of_pair;

  PairColumns(const std::vector<SampleSet>& answered, std::span<const MethodPair> pairs) {
    for (const auto& [first, second] : pairs) {
      const SampleSet both = answered[first] & answered[second];
      of_pair.emplace_back(column_of(first, both), column_of(second, both));
    }
  }

 private:
  std::size_t column_of(std::size_t method, const SampleSet& samples) {
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (columns[c].method == method && columns[c].samples == samples) return c;
    columns.push_back({method, samples});
    return columns.size() - 1;
  }
};

struct DistanceSum {
  std::uint32_t n = 0;
  double length_m = 0.0;
  void add(const DistanceSum& more) {
    n += more.n;
    length_m += more.length_m;
  }
};

// Sums the pairs of one track.
class TrackPairs {
 public:
  TrackPairs(const StoredTake& take, std::size_t track, const ErrorSettings& settings,
             std::span<const MethodPair> pairs, PairErrors& errors)
      : head_(take.head()),
        track_(track),
        settings_(settings),
        pairs_(pairs),
        alignments_(settings.alignments.size()),
        windows_(take, track, block_instants(head_.instants, settings.rate_hz), 0),
        marks_(windows_, head_),
        columns_(marks_.answered(), pairs),
        aligned_(windows_, head_, marks_, settings, columns_.columns),
        lengths_(columns_.columns.size() * head_.joints.size() * alignments_),
        errors_(errors) {}

  void add_up() {
    windows_.each(
        [&](const Window& w) {
          for (std::size_t c = 0; c < columns_.columns.size(); ++c)
            for (std::size_t j = 0; j < head_.joints.size(); ++j)
              for (std::size_t a = 0; a < alignments_; ++a) add_lengths(w, c, j, a);
        },
        [&](std::uint32_t block) { end_block(block); });
  }

 private:
  using Parts = std::array<DistanceSum, kSubsetCombinations>;
  Parts& parts_of(std::size_t c, std::size_t j, std::size_t a) {
    return lengths_[(c * head_.joints.size() + j) * alignments_ + a];
  }

  void add_lengths(const Window& w, std::size_t c, std::size_t j, std::size_t a) {
    const SampleColumn& column = columns_.columns[c];
    const JointAlignment& aligned = aligned_.of(a, c, j);
    Parts& parts = parts_of(c, j, a);
    for (std::uint64_t i = std::max(w.first, aligned.first_instant); i < w.end; ++i) {
      if (!column.samples.has(marks_.place(i, j))) continue;
      const double length_m =
          (aligned.aligned_m(w.estimate_m(w.slot(i, j, column.method)), w.block.heading_rad[i - w.begins()]) -
           w.truth_m(i, j))
              .norm();
      if (std::isfinite(length_m)) parts[marks_.subset_of(i, j)].add({1, length_m});
    }
  }

  void end_block(std::uint32_t block) {
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const auto [first, second] = columns_.of_pair[p];
      for (std::uint32_t j = 0; j < head_.joints.size(); ++j)
        for (std::uint32_t a = 0; a < alignments_; ++a)
          for (std::uint32_t subset = 0; subset < (settings_.occluded_apart ? 2 : 1); ++subset) {
            const DistanceSum of_first = sum_of(parts_of(first, j, a), subset),
                              of_second = sum_of(parts_of(second, j, a), subset);
            if (of_first.n == 0 || of_second.n != of_first.n) continue;
            errors_[pairs_[p]].push_back({block, static_cast<std::uint32_t>(track_ * head_.joints.size()) + j,
                                          a, subset, of_first.n, of_first.length_m, of_second.length_m});
          }
    }
    for (Parts& parts : lengths_) parts = {};
  }

  static DistanceSum sum_of(const Parts& parts, std::uint32_t subset) {
    DistanceSum sum;
    for (std::size_t part = 0; part < kSubsetCombinations; ++part)
      if (is_part_of(part, static_cast<Subset>(subset))) sum.add(parts[part]);
    return sum;
  }

  const TakeHead& head_;
  const std::size_t track_;
  const ErrorSettings& settings_;
  const std::span<const MethodPair> pairs_;
  const std::size_t alignments_;
  const Windows windows_;
  const SampleFlags marks_;
  const PairColumns columns_;
  const ColumnAlignments aligned_;
  std::vector<Parts> lengths_;  // by column, joint and alignment, of the current block of time
  PairErrors& errors_;
};

}  // namespace

PairErrors pair_errors(const StoredTake& take, const ErrorSettings& settings,
                       std::span<const MethodPair> pairs) {
  PairErrors errors;
  for (const MethodPair& pair : pairs) errors[pair];
  for (std::size_t track = 0; track < take.head().tracks.size(); ++track)
    TrackPairs(take, track, settings, pairs, errors).add_up();
  return errors;
}

}  // namespace trilat
