// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/samples.h"
#include "pipeline/accuracy/statistics/aligned_errors.h"
#include "pipeline/accuracy/statistics/take_statistics.h"

namespace trilat {

// What one take adds to the summary of a study, made from its samples alone.
struct TakeSummary {
  std::vector<AlignmentTable> alignments;  // by kind, each on all of a method's answers
  TakeStatistics statistics;
  std::string file = {};  // that it was read from, for errors
};

// Streams the take's samples twice. `take`: of the file.
TakeSummary summarise_take(const SamplesFile& samples, std::size_t take, const StatisticsLayout& layout);

// summary.bin, which lies beside the samples of each take, so that a study only adds. `key` says what the
// summary was made with; everything comes back as it was, to the bit.
void write_take_summary(const std::filesystem::path& folder, const std::string& key,
                        const TakeSummary& summary);
// Nothing when there is none of this key; InputError when the file is damaged, not of this layout and number
// of instants, or counts what cannot be.
std::optional<TakeSummary> read_take_summary(const std::filesystem::path& folder, const std::string& key,
                                             const StatisticsLayout& layout, std::uint64_t instants);

}  // namespace trilat
