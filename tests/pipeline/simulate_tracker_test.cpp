// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include "datasets/base/files.h"
#include "tests/pipeline/campaigns.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

SimulationSpec tracked_spec() {
  SimulationSpec spec = walking_spec(2);
  spec.body_tracker = default_body_tracker();
  return spec;
}

TEST(SimulateTracker, IsTheSameToTheByteOnOneThreadAndOnSeveral) {
  const ScratchFolder folder;
  simulate_into(folder / "several", tracked_spec());
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  simulate_into(folder / "one", tracked_spec());
  for (const char* take : {"p01-walking", "p02-walking"})
    for (const char* file : {"session.h5", "truth.json"})
      EXPECT_EQ(read_file(folder / "one" / take / file), read_file(folder / "several" / take / file)) << file;
}

}  // namespace
}  // namespace trilat
