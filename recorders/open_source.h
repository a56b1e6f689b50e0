// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datasets/synthetic/simulation_spec.h"
#include "recorders/frame_source.h"
#include "recorders/live_source.h"
#include "recorders/synthetic_source.h"

namespace trilat {

// Virtual Kinects watching a generated person walk, as one asks for them by text.
struct SyntheticRequest {
  std::size_t sensors = 4;
  std::uint64_t seed = 1;
  bool depth = true;
  double duration_s = 86400.0;
  LiveOptions live;
};

// What such a source watches and with what; the same for equal requests.
struct SyntheticSetup {
  SimulationSpec simulation;
  SimulatedItem item;
  Motion motion;
  std::vector<SimulatedSensor> sensors;
};
SyntheticSetup setup_of(const SyntheticRequest& request);

// The request in a text "synthetic:…"; nothing when the text asks for another kind of source. InputError as
// in open_source().
std::optional<SyntheticRequest> synthetic_request(const std::string& text);

// On an agent all arrivals are stamped with this machine's clock, which the recording machine compares with
// its own; that needs real speed.
enum class SourceUse { record, agent };

// A source by its text, KIND:WHAT with settings KEY=VALUE behind commas:
//   synthetic:N          N virtual Kinects and a walking person; seed=1, depth=yes, duration=SECONDS,
//                        speed=FACTOR (1; max: as fast as it can be taken)
// `place` is what an InputError names.
std::unique_ptr<FrameSource> open_source(const std::string& text, const std::string& place = "--source",
                                         SourceUse use = SourceUse::record);

// The texts that open_source() takes, for people.
std::string source_help();

}  // namespace trilat
