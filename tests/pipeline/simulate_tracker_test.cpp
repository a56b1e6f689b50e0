// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include "datasets/base/files.h"
#include "datasets/session/session_reader.h"
#include "datasets/synthetic/tracker/tracker_truth.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

SimulationSpec tracked_spec() {
  SimulationSpec spec = walking_spec(2);
  spec.body_tracker = default_body_tracker();
  spec.bystanders = 1;
  return spec;
}

TEST(SimulateTracker, EveryFrameOfEverySensorHasItsTruthBesideIt) {
  const ScratchFolder folder;
  simulate_into(folder.path(), tracked_spec());
  const Campaign campaign = read_campaign(folder.path());
  ASSERT_EQ(campaign.takes.size(), 2u);
  bool hidden = false, others = false, found = false;
  for (const Take& take : campaign.takes) {
    const SessionReader session(take.session);
    const TrackerTruthReader truth(take.tracker_truth);
    for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
      const std::string name = session.header().sensors[s].name;
      const std::uint64_t frames = session.counts(s).body_frames;
      EXPECT_GT(frames, 20u);
      ASSERT_EQ(truth.frames(name), frames);
      const auto rows = truth.read(name, 0, frames);
      const auto bodies = session.body_frames(s, 0, frames);
      for (std::size_t i = 0; i < frames; ++i) {
        EXPECT_EQ(rows[i].sequence, bodies[i].stamp.sequence);
        hidden = hidden || rows[i].hidden != 0;
        others = others || bodies[i].bodies.size() == 2;
        for (const Body& body : bodies[i].bodies) found = found || body.tracking_id == rows[i].tracking_id;
      }
    }
  }
  EXPECT_TRUE(hidden && others && found);
}

TEST(SimulateTracker, IsTheSameToTheByteOnOneThreadAndOnSeveral) {
  const ScratchFolder folder;
  simulate_into(folder / "several", tracked_spec());
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  simulate_into(folder / "one", tracked_spec());
  for (const char* take : {"p01-walking", "p02-walking"})
    for (const char* file : {"tracker_truth.h5", "session.h5", "truth.json"})
      EXPECT_EQ(read_file(folder / "one" / take / file), read_file(folder / "several" / take / file)) << file;
}

// From a campaign to a tracker, and from the tracker to a campaign of its own.
TEST(MeasureTrackerVerb, WritesATrackerThatASimulationTakes) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(3, 4.0);
  spec.body_tracker = default_body_tracker();
  simulate_into(folder / "campaign", spec);
  const std::string campaign = (folder / "campaign").string(), tracker = (folder / "tracker.json").string();
  const Ended measured = run_trilat(folder, {"measure-tracker", campaign, "-o", tracker});
  ASSERT_EQ(measured.code, 0) << measured.err;
  EXPECT_THAT(measured.out,
              testing::AllOf(testing::HasSubstr("view_bias_sigma_m\n  head"),
                             testing::HasSubstr("measured on 3 takes of 3 participants (tiny)"),
                             testing::HasSubstr("unit_depth_share: left as declared; is part of")));
  const Json document = read_json(tracker);
  EXPECT_EQ(document.at("groups").at("view_bias_sigma_m").at("interval").at("head").size(), 2u);
  EXPECT_EQ(document.at("values").at("unit_depth_share"),
            declared_body_tracker().at("values").at("unit_depth_share"));
  const std::string simulation = file_with(
      folder, "sim.json",
      R"({"format": "trilat.simulation", "version": 1, "participants": 1, "body_tracker": "tracker.json",
          "activities": [{"name": "walking", "duration_s": 0.3}]})");
  EXPECT_EQ(run_trilat(folder, {"simulate", simulation, "-o", (folder / "twin").string()}).code, 0);
  // its own earlier output is replaced, somebody else's file is not
  EXPECT_EQ(run_trilat(folder, {"measure-tracker", campaign, "-o", tracker}).code, 0);
  expect_refused(run_trilat(folder, {"measure-tracker", campaign, "-o", simulation}),
                 "exists and is no tracker");
  expect_refused(run_trilat(folder, {"measure-tracker", (folder / "nowhere").string(), "-o", tracker}),
                 "nowhere");
}

}  // namespace
}  // namespace trilat
