// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/results/stored_take.h"
#include "evaluators/alignment/alignment.h"

namespace trilat {

// Settings that decide the errors of a take, beside its samples.
struct ErrorSettings {
  std::vector<AlignmentKind> alignments;
  double training_share = 0.0;  // of a take's instants, at its start: what trained alignments learn from
  bool occluded_apart = false;  // whether samples that a sensor sees occluded are a subset of their own
  double rate_hz = 30.0;        // of the instants

  // The place of the alignment that whole bodies are measured under: none when the study has it, else the
  // first.
  std::uint32_t body_alignment() const;
  // The first instant that trained alignments do not learn from; 0 without any.
  std::uint64_t training_end(std::uint64_t instants) const;
  std::string sha256() const;
};

// The instants of a block of time: five seconds; a twelfth of the take where that is longer.
std::uint64_t block_instants(std::uint64_t instants, double rate_hz);

// The errors of a take's samples. Reads the file three times, from memory where its samples are below 64 MB.
TakeErrors errors_of(const StoredTake& take, const ErrorSettings& settings);

}  // namespace trilat
