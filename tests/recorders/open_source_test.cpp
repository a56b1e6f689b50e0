// SPDX-License-Identifier: MIT
#include "recorders/open_source.h"

#include <chrono>

#include <gmock/gmock.h>

#include "datasets/session/clock/session_clock.h"
#include "datasets/session/session_reader.h"
#include "recorders/capture.h"
#include "recorders/freenect2/freenect2_source.h"
#include "recorders/recorder.h"
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
  EXPECT_THAT(message("azure:1"), HasSubstr("no source \"azure\"; there are synthetic:4"));
  EXPECT_THAT(message("kinect"), HasSubstr("trilat-agent.exe"));
  EXPECT_THAT(message("freenect2:1,colour=yes"), HasSubstr("no setting \"colour\"; it has pipeline"));
  EXPECT_THAT(message("synthetic:0"), HasSubstr("the number of sensors must be a number from 1 to 16"));
  EXPECT_THAT(message("synthetic:4,colour=yes"), HasSubstr("no setting \"colour\"; it has seed, depth"));
  EXPECT_THAT(message("synthetic:4,depth"), HasSubstr("settings of a source are KEY=VALUE"));
  EXPECT_THAT(message("synthetic:4,depth=no,depth=yes"), HasSubstr("\"depth\" is set twice"));
  EXPECT_THAT(message("synthetic:4,stall=3"), HasSubstr("AT+SECONDS"));
  EXPECT_THAT(message("replay"), HasSubstr("needs a session"));
  EXPECT_THAT(message("replay:/nowhere.h5"), HasSubstr("/nowhere.h5: does not exist"));
}

TEST(OpenSource, HelpNamesASensorOnlyWhereItsDriverIsBuiltIn) {
  EXPECT_EQ(source_help().find("freenect2") != std::string::npos, has_freenect2());
  if (has_freenect2()) return;
  EXPECT_THAT(message_of([] { open_source("freenect2"); }), HasSubstr("install libfreenect2"));
}

TEST(OpenSource, FaultsHappenWhenTheyWereAskedFor) {
  const auto faulty =
      all_of(*open_source("synthetic:1,depth=no,duration=2,drop=0,speed=max,stall=0.5+0.5,jump=1.5+100"));
  std::int64_t lost = 0, jumped = 0, frames = 0;
  std::optional<FrameStamp> last;
  for (const SourceEvent& event : faulty) {
    if (const auto* count = std::get_if<DropCount>(&event.data)) lost = count->at_source;
    const auto* frame = std::get_if<BodyFrame>(&event.data);
    if (!frame) continue;
    ++frames;
    if (last && frame->stamp.device_ticks - last->device_ticks > 500'000'000) ++jumped;
    last = frame->stamp;
  }
  EXPECT_NEAR(static_cast<double>(lost), 15.0, 1.0);
  EXPECT_EQ(frames + lost, 60);
  EXPECT_EQ(jumped, 1);
  EXPECT_THROW(all_of(*open_source("synthetic:1,depth=no,duration=2,speed=max,unplug=1")), InputError);
}

// The arrivals are those of this machine's clock; a second of them takes a second.
TEST(OpenSource, ALiveSensorIsPacedAndStampedWithThisMachinesClock) {
  const auto now_ns = [] {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
  };
  const std::int64_t before = now_ns();
  const auto events = all_of(*open_source("synthetic:2,depth=no,duration=1,drop=0"));
  const std::int64_t after = now_ns();
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

TEST(OpenSource, AReplayedSessionIsTheSameSessionLater) {
  const ScratchFolder folder;
  {
    const auto source = open_source("synthetic:2,duration=1,speed=max");
    record(*source, folder / "first.h5", {});
  }
  std::vector<std::unique_ptr<FrameSource>> sources;
  sources.push_back(open_source("replay:" + (folder / "first.h5").string() + ",speed=max"));
  capture(sources, folder / "again.h5", {});
  const SessionReader first(folder / "first.h5"), again(folder / "again.h5");
  for (std::size_t s = 0; s < 2; ++s) {
    ASSERT_EQ(again.counts(s).body_frames, first.counts(s).body_frames);
    ASSERT_EQ(again.counts(s).depth_frames, first.counts(s).depth_frames);
    ASSERT_EQ(again.counts(s).clock_exchanges, first.counts(s).clock_exchanges);
    const auto a = first.stamps(s, FrameStream::depth, 0, first.counts(s).depth_frames);
    const auto b = again.stamps(s, FrameStream::depth, 0, a.size());
    const std::int64_t moved_ns = b[0].arrival_ns - a[0].arrival_ns;
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(b[i].device_ticks, a[i].device_ticks);
      EXPECT_EQ(b[i].arrival_ns - a[i].arrival_ns, moved_ns);
      EXPECT_EQ(again.stored_depth_frame(s, i).chunk, first.stored_depth_frame(s, i).chunk);
    }
    const auto e = first.clock_exchanges(s), f = again.clock_exchanges(s);
    for (std::size_t i = 0; i < e.size(); ++i) EXPECT_EQ(f[i].t2_ns - e[i].t2_ns, moved_ns);
  }
}

}  // namespace
}  // namespace trilat
