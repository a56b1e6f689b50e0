// SPDX-License-Identifier: MIT
// Files of our own making: no real one was at hand.
#include <gmock/gmock.h>

#include "datasets/import/import_xef.h"
#include "tests/datasets/import/import_fixtures.h"
#include "tests/datasets/import/made_up_xef.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint64_t kId = 72057594037931648u;
constexpr std::int64_t kPeriodTicks = 333'333;

// Depth in stream 1, bodies in stream 2, infrared in stream 3; frame 2 was lost.
MadeUpXef recording(bool archived) {
  MadeUpXef xef(3, archived);
  xef.describe(1, kXefDepth);
  xef.describe(2, kXefBodies);
  xef.describe(3, kXefInfrared);
  if (archived) xef.index_block(0x6000);
  for (const int i : {0, 1, 3}) {
    xef.event(1, i * kPeriodTicks, static_cast<std::uint32_t>(100 + i), made_up_depth(i));
    xef.event(3, i * kPeriodTicks, static_cast<std::uint32_t>(100 + i), made_up_depth(i));
    xef.event(2, i * kPeriodTicks + 50, static_cast<std::uint32_t>(100 + i), made_up_bodies(i, kId));
    if (i == 1) xef.index_block(0x7000);
  }
  if (!archived) xef.footer();
  return xef;
}

void expect_all(const Imported& result) {
  EXPECT_EQ(result.session.counts(0).depth_frames, 3u);
  const auto frames = result.frames();
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_THAT(sequences(frames), ElementsAre(100, 101, 103));
  EXPECT_EQ(frames[2].stamp.device_ticks, 3 * kPeriodTicks + 50);
  EXPECT_EQ(frames[2].floor_plane[1], 1.0f);
  const Body& body = frames[2].bodies.at(0);
  EXPECT_EQ(body.tracking_id, kId);
  EXPECT_EQ(body.position_m[9][2], 2.0f + 0.01f * 9.0f);
  EXPECT_THAT(body.orientation_xyzw[9], ElementsAre(0.0f, 0.0f, 0.0f, 1.0f));
  EXPECT_EQ(body.tracking_state[9], 1);
  EXPECT_THAT(body.hand_state, ElementsAre(3, 2));
  EXPECT_THAT(body.hand_confidence, ElementsAre(1, 0));
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  result.session.depth_frame(0, 2, depth_mm);
  EXPECT_EQ(depth_mm[0], 800);
  EXPECT_EQ(depth_mm[kDepthPixels - 1], 800 + 511);
  EXPECT_EQ(result.report.sensors[0].skipped_events, 3);
  EXPECT_EQ(result.report.sensors[0].skipped_bytes, 0);
  EXPECT_EQ(result.report.sensors[0].left_out.total(), 0);
}

TEST(XefImport, ReadsDepthAndBodiesOfAPlainFile) {
  const ScratchFolder folder;
  expect_all(imported(folder, "xef", {text_file(folder, "a.xef", recording(false).bytes())}));
}

TEST(XefImport, ReadsDepthAndBodiesOfAnArchivedFile) {
  const ScratchFolder folder;
  expect_all(imported(folder, "xef", {text_file(folder, "a.xef", recording(true).bytes())}));
}

TEST(XefImport, AFileWithoutBodiesIsFine) {
  const ScratchFolder folder;
  MadeUpXef xef(1);
  xef.describe(1, kXefDepth);
  xef.event(1, 0, 7, made_up_depth(0));
  const Imported result = imported(folder, "xef", {text_file(folder, "a.xef", xef.bytes())});
  EXPECT_EQ(result.session.counts(0).depth_frames, 1u);
  EXPECT_EQ(result.session.counts(0).body_frames, 0u);
  EXPECT_THAT(result.report.note, HasSubstr("not yet been run on a real file"));
}

TEST(XefImport, StepsOverDamageToTheNextFrame) {
  const ScratchFolder folder;
  MadeUpXef xef(1);
  xef.describe(1, kXefDepth);
  for (int i = 0; i < 2; ++i) xef.event(1, i * kPeriodTicks, static_cast<std::uint32_t>(i), made_up_depth(i));
  xef.bytes().append(1000, '\x55');
  xef.event(1, 2 * kPeriodTicks, 2, made_up_depth(2));
  const Imported result = imported(folder, "xef", {text_file(folder, "a.xef", xef.bytes())});
  EXPECT_EQ(result.session.counts(0).depth_frames, 3u);
  EXPECT_EQ(result.report.sensors[0].skipped_bytes, 1000);
}

TEST(XefImport, KeepsWhatStandsBeforeTheCutOfAFile) {
  const ScratchFolder folder;
  MadeUpXef xef(1);
  xef.describe(1, kXefDepth);
  for (int i = 0; i < 2; ++i) xef.event(1, i * kPeriodTicks, static_cast<std::uint32_t>(i), made_up_depth(i));
  xef.bytes().resize(xef.bytes().size() - 5000);
  const Imported result = imported(folder, "xef", {text_file(folder, "a.xef", xef.bytes())});
  EXPECT_EQ(result.session.counts(0).depth_frames, 1u);
  EXPECT_GT(result.report.sensors[0].skipped_bytes, 400'000);
}

TEST(XefImport, AFrameThatCannotBeInflatedIsCounted) {
  const ScratchFolder folder;
  MadeUpXef xef(1, true);
  xef.describe(1, kXefDepth);
  xef.event(1, 0, 0, made_up_depth(0));
  const std::size_t end = xef.bytes().size();
  xef.event(1, kPeriodTicks, 1, made_up_depth(1));
  xef.bytes()[end + 24 + 4 + 200] ^= 0x5a;
  const Imported result = imported(folder, "xef", {text_file(folder, "a.xef", xef.bytes())});
  EXPECT_EQ(result.session.counts(0).depth_frames, 1u);
  EXPECT_EQ(result.report.sensors[0].left_out.torn_rows, 1);
  EXPECT_THAT(result.report.sensors[0].left_out.first, HasSubstr("a.xef (byte " + std::to_string(end) + ")"));
}

TEST(XefImport, ABodyWithAHandStateThatDoesNotExistIsCounted) {
  const ScratchFolder folder;
  for (const std::int32_t state : {-1, 4, 1'000'000}) {
    MadeUpXef xef(1, true);
    xef.describe(1, kXefBodies);
    xef.event(1, 0, 0, made_up_bodies(0, kId));
    std::string bodies = made_up_bodies(1, kId);
    MadeUpXef::write(bodies, 32 + 1040 * 3 + 980, state);
    xef.event(1, kPeriodTicks, 1, bodies);
    const Imported result = imported(folder, "xef", {text_file(folder, "a.xef", xef.bytes())});
    EXPECT_EQ(result.frames().size(), 1u) << state;
    EXPECT_EQ(result.report.sensors[0].left_out.torn_rows, 1) << state;
  }
}

TEST(XefImport, RefusesOtherFilesByTheirSignature) {
  const ScratchFolder folder;
  const auto refusal = [&](const std::string& bytes) {
    return import_refusal(folder, "xef", {text_file(folder, "a.xef", bytes)});
  };
  EXPECT_THAT(refusal(""), HasSubstr("EVENTS1"));
  EXPECT_THAT(refusal(std::string(100, 'x')), HasSubstr("EVENTS1"));
  EXPECT_THAT(refusal("PK\x03\x04" + std::string(100, 'x')), HasSubstr("HoloLens"));
  MadeUpXef raw(1);
  raw.describe(1, kXefRawInfrared);
  raw.event(1, 0, 0, "raw");
  EXPECT_THAT(refusal(raw.bytes()), HasSubstr(".xrf"));
  EXPECT_THAT(refusal(MadeUpXef(1).bytes()), HasSubstr("neither depth nor bodies"));
}

}  // namespace
}  // namespace trilat
