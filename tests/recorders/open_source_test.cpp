// SPDX-License-Identifier: MIT
#include "recorders/open_source.h"

#include <gmock/gmock.h>

#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

std::vector<SourceEvent> all_of(FrameSource& source) {
  std::vector<SourceEvent> events;
  while (auto event = source.next()) events.push_back(std::move(*event));
  return events;
}

TEST(OpenSource, WrongTextsSayWhatWouldBeRight) {
  const auto message = [](const std::string& text) { return message_of([&] { open_source(text); }); };
  EXPECT_THAT(message("azure:1"), HasSubstr("no source \"azure\"; there is synthetic:4"));
  EXPECT_THAT(message("kinect"), HasSubstr("trilat-agent.exe"));
  EXPECT_THAT(message("synthetic:0"), HasSubstr("the number of sensors must be a number from 1 to 16"));
  EXPECT_THAT(message("synthetic:4,colour=yes"), HasSubstr("no setting \"colour\"; it has seed, depth"));
  EXPECT_THAT(message("synthetic:4,depth"), HasSubstr("settings of a source are KEY=VALUE"));
  EXPECT_THAT(message("synthetic:4,depth=no,depth=yes"), HasSubstr("\"depth\" is set twice"));
  EXPECT_THAT(message("synthetic:4,depth=all"), HasSubstr("depth must be yes, no or wand, is \"all\""));
  EXPECT_THAT(message("synthetic:4,drop=0.1"), HasSubstr("no setting \"drop\""));
}

// The arrivals are those of this machine's clock; a second of them takes a second.
TEST(OpenSource, ALiveSensorIsPacedAndStampedWithThisMachinesClock) {
  const std::int64_t before = host_now_ns();
  const auto events = all_of(*open_source("synthetic:2,depth=no,duration=1"));
  const std::int64_t after = host_now_ns();
  EXPECT_GT(after - before, 900'000'000);
  std::size_t frames = 0;
  for (const SourceEvent& event : events)
    if (const auto* frame = std::get_if<BodyFrame>(&event.data)) {
      ++frames;
      EXPECT_GT(frame->stamp.arrival_ns, before);
      EXPECT_LT(frame->stamp.arrival_ns, after);
    }
  EXPECT_EQ(frames, 60u);
}

}  // namespace
}  // namespace trilat
