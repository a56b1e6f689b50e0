// SPDX-License-Identifier: MIT
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>

#include <gmock/gmock.h>
#include <hdf5.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/philox.h"
#include "datasets/hdf5/hdf5_file.h"
#include "datasets/session/body_readings.h"
#include "datasets/session/clock/session_clock.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_verify.h"
#include "datasets/session/session_writer.h"
#include "tests/datasets/made_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

std::filesystem::path scratch(const std::string& name) {
  static const ScratchFolder folder;  // removed when the program ends
  return folder / name;
}

using Change = std::function<bool(std::int64_t, BodyFrame&)>;  // false: without this frame

// Frames of one body, seen by one sensor, and whatever `more` adds.
std::filesystem::path written(const std::string& name, std::int64_t frames, const Change& change = {},
                              const std::function<void(SessionWriter&)>& more = {}) {
  const auto path = scratch(name);
  SessionWriter writer(path, header_of(1));
  for (std::int64_t i = 0; i < frames; ++i) {
    BodyFrame frame = body_frame_of(i, 1);
    if (!change || change(i, frame)) writer.add_body_frame(0, frame);
  }
  if (more) more(writer);
  writer.finish();
  return path;
}

// "severity text | endangers", a line a finding.
std::string said_of(const std::filesystem::path& path) {
  std::string said;
  for (const Finding& f : verify_session(SessionReader(path), {}))
    said += std::string(name_of(f.severity)) + " " + f.text + " | " + f.affects + "\n";
  return said;
}

TEST(Session, WhatIsWrittenIsReadBack) {
  const auto path = scratch("round_trip.h5");
  SessionWriter writer(path, header_of(2));
  for (std::int64_t i = 0; i < 2500; ++i) {
    writer.add_body_frame(0, body_frame_of(i, static_cast<std::size_t>(i) % 3));
  }
  writer.add_clock_exchange(1, {1, 2, 3, 4});
  writer.add_drop_count(1, {9, 8, 7});
  writer.finish();

  const SessionReader reader(path);
  EXPECT_TRUE(reader.complete());
  EXPECT_TRUE(reader.header().simulated);
  EXPECT_EQ(reader.header().sensors[1].serial, "00001");
  EXPECT_EQ(reader.header().sensors[0].intrinsics.fx_px, DepthIntrinsics{}.fx_px);
  EXPECT_EQ(reader.counts(0).body_frames, 2500u);
  EXPECT_EQ(reader.counts(0).bodies, 2499u);
  EXPECT_EQ(reader.counts(1).body_frames, 0u);
  const auto frames = reader.body_frames(0, 1500, 700);  // across blocks, from the middle
  ASSERT_EQ(frames.size(), 700u);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const BodyFrame expected = body_frame_of(static_cast<std::int64_t>(1500 + i), (1500 + i) % 3);
    EXPECT_EQ(frames[i].stamp.device_ticks, expected.stamp.device_ticks);
    EXPECT_EQ(frames[i].floor_plane, expected.floor_plane);
    ASSERT_EQ(frames[i].bodies.size(), expected.bodies.size());
    for (std::size_t b = 0; b < expected.bodies.size(); ++b) {
      EXPECT_EQ(frames[i].bodies[b].tracking_id, expected.bodies[b].tracking_id);
      EXPECT_EQ(frames[i].bodies[b].position_m, expected.bodies[b].position_m);
      EXPECT_EQ(frames[i].bodies[b].tracking_state, expected.bodies[b].tracking_state);
      EXPECT_EQ(frames[i].bodies[b].hand_state, expected.bodies[b].hand_state);
    }
  }
  EXPECT_EQ(reader.clock_exchanges(1)[0].t3_ns, 3);
  EXPECT_EQ(reader.drop_counts(1)[0].in_queue, 7);
}

TEST(Session, DepthSurvivesEveryCompressionBitByBit) {
  for (const auto compression :
       {ChunkCompression::none, ChunkCompression::blosc, ChunkCompression::deflate}) {
    const auto path = scratch("depth.h5");
    SessionWriter writer(path, header_of(1, true), compression);
    for (std::uint16_t i = 0; i < 5; ++i)
      writer.add_depth_frame(0,
                             encode_depth_frame({i, i * 333'333, i * 33'333'300}, depth_of(i), compression));
    writer.finish();
    const SessionReader reader(path);
    ASSERT_EQ(reader.counts(0).depth_frames, 5u);
    std::vector<std::uint16_t> depth(kDepthPixels);
    for (std::uint16_t i = 0; i < 5; ++i) {
      reader.depth_frame(0, i, depth);
      EXPECT_EQ(depth, depth_of(i)) << "compression " << static_cast<int>(compression);
      StoredDepthFrame stored = reader.stored_depth_frame(0, i);
      EXPECT_EQ(stored.compression, compression);
      std::ranges::fill(depth, std::uint16_t{9});
      decode_depth_frame(stored, depth);
      EXPECT_EQ(depth, depth_of(i)) << "compression " << static_cast<int>(compression);
      stored.chunk[stored.chunk.size() / 2] ^= std::byte{1};
      EXPECT_THROW(decode_depth_frame(stored, depth), InputError);
    }
    if (compression != ChunkCompression::none) {
      EXPECT_LT(reader.depth_stored_bytes(0), 5 * kDepthPixels);
    }
  }
}

TEST(Session, AChangedByteOfDepthIsFoundByVerify) {
  const auto path = scratch("damaged.h5");
  SessionWriter writer(path, header_of(1, true));
  const auto encoded = encode_depth_frame({1, 333'333, 33'333'300}, depth_of(3), ChunkCompression::blosc);
  writer.add_depth_frame(0, encoded);
  writer.finish();
  std::string bytes = read_file(path);
  const std::string chunk(reinterpret_cast<const char*>(encoded.chunk.data()), encoded.chunk.size());
  const auto at = bytes.find(chunk);
  ASSERT_NE(at, std::string::npos);
  bytes[at + chunk.size() / 2] ^= 0x10;
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_THAT(said_of(path), HasSubstr("1 frames are damaged"));
}

TEST(Session, AChangedByteAmongTheLastBodiesIsRefused) {
  const auto path = scratch("damaged.h5");
  SessionWriter writer(path, header_of(1));
  BodyFrame frame{{1, 333'333, 33'333'300}, {}, {standing_body()}};
  frame.bodies[0].position_m[3] = {0.123F, 0.456F, 2.789F};
  writer.add_body_frame(0, frame);
  writer.finish();
  std::string bytes = read_file(path);
  std::string wanted(12, '\0');
  std::memcpy(wanted.data(), frame.bodies[0].position_m[3].data(), 12);
  const auto at = bytes.find(wanted);
  ASSERT_NE(at, std::string::npos) << "positions are stored as they are";
  bytes[at] ^= 0x10;
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_THAT(said_of(path), HasSubstr("the stored data are damaged"));
}

TEST(Session, DepthFramesWithoutAnyDepthAreCounted) {
  for (const int empty : {0, 2}) {
    const auto path = scratch("empty.h5");
    SessionWriter writer(path, header_of(1, true));
    for (int i = 0; i < 5; ++i) {
      std::vector<std::uint16_t> depth_mm(kDepthPixels, 0);
      if (i >= empty) depth_mm[7] = 1500;
      writer.add_depth_frame(
          0, encode_depth_frame({i, 333'333 * i, 33'333'300 * i}, depth_mm, ChunkCompression::deflate));
    }
    writer.finish();
    const std::string said = said_of(path);
    EXPECT_EQ(said.find("2 frames hold no depth at all") != std::string::npos, empty == 2) << said;
    EXPECT_EQ(said.find("hold no depth at all") != std::string::npos, empty > 0) << said;
  }
}

TEST(Session, RatesOfATenthToTenThousandHertzAreRead) {
  const auto read = [](double rate_hz) {
    const auto path = scratch("rate.h5");
    SessionHeader header = header_of(1);
    header.sensors[0].nominal_rate_hz = rate_hz;
    SessionWriter(path, header).finish();
    return message_of([&] { SessionReader{path}; });
  };
  EXPECT_EQ(read(0.11), "no error");
  EXPECT_EQ(read(9999.0), "no error");
  for (const double rate_hz : {0.1, 10'000.0})
    EXPECT_THAT(read(rate_hz), HasSubstr("nominal_rate_hz: must lie between 0.1 and 10000"));
}

TEST(Session, OtherFilesAreRefusedWithTheReason) {
  EXPECT_THAT(message_of([] { SessionReader("/nonexistent.h5"); }), HasSubstr("does not exist"));
  const auto text = scratch("text.h5");
  std::ofstream(text) << "not HDF5";
  EXPECT_THAT(message_of([&] { SessionReader reader(text); }), HasSubstr("is not an HDF5 file, as sessions"));
  const std::pair<std::string, const char*> texts[] = {
      {"", "is empty"},
      {"version https://git-lfs.github.com/spec/v1\n", "is a pointer of Git LFS; `git lfs pull`"},
      {"<!DOCTYPE html>", "is a web page"},
      {"PK\x03\x04 ", "an archive"}};
  for (const auto& [begin, problem] : texts) {
    write_file(text, begin);
    EXPECT_THAT(message_of([&] { SessionReader reader(text); }), HasSubstr(problem)) << begin;
  }
  const auto other = scratch("other.h5");
  H5File::create(other).set_text("format", "something else");
  EXPECT_THAT(message_of([&] { SessionReader reader(other); }), HasSubstr("not a session"));
  const auto newer = scratch("newer.h5");
  {
    H5File file = H5File::create(newer);
    file.set_text("format", "trilat.session");
    file.set_integer("version", 2);
  }
  EXPECT_THAT(message_of([&] { SessionReader reader(newer); }), HasSubstr("format version 2"));
}

TEST(Session, ATruncatedFileIsRefusedNotCrashedOn) {
  const auto path = scratch("whole.h5");
  SessionWriter writer(path, header_of(2));
  for (std::int64_t i = 0; i < 200; ++i) writer.add_body_frame(0, body_frame_of(i, 2));
  writer.finish();
  const std::string bytes = read_file(path);
  const auto cut = scratch("cut.h5");
  for (std::size_t size = 0; size < bytes.size(); size += bytes.size() / 37) {
    std::ofstream(cut, std::ios::binary) << bytes.substr(0, size);
    EXPECT_THAT(message_of([&] {
                  const SessionReader reader(cut);
                  reader.body_frames(0, 0, reader.counts(0).body_frames);
                }),
                HasSubstr("cut.h5"));
  }
}

TEST(Session, AskingBeyondTheEndIsRefused) {
  const SessionReader reader(written("short.h5", 3));
  EXPECT_THAT(message_of([&] { reader.body_frames(0, 2, 2); }), HasSubstr("has 3 whole rows"));
  EXPECT_THAT(message_of([&] { reader.body_frames(0, 1, ~std::uint64_t{0}); }),
              HasSubstr("has 3 whole rows"));
  EXPECT_THAT(message_of([&] { reader.sensor_index("k9"); }), HasSubstr("it has k0"));
}

TEST(Session, VerifySaysWhatIsOdd) {
  const std::string said = said_of(written("odd.h5", 60, [](std::int64_t i, BodyFrame& frame) {
    if (i == 30) frame.bodies[0].position_m[1][0] = std::numeric_limits<float>::quiet_NaN();
    if (i == 40) frame.bodies[0].tracking_state[5] = 9;
    return i != 20 && i != 21;
  }));
  for (const char* odd : {"2 frames are missing", "1 gaps in time, the longest 0.100 s",
                          "1 tracked or inferred joints are not finite", "1 states are none of 0, 1, 2"})
    EXPECT_THAT(said, HasSubstr(odd));
  EXPECT_THAT(said, Not(HasSubstr("damaged")));
}

TEST(Session, VerifyCountsJointsOutOfReachAndJumpsOfABody) {
  const std::string said = said_of(written("spoiled.h5", 60, [](std::int64_t i, BodyFrame& frame) {
    Body& body = frame.bodies[0];
    for (std::size_t j = 0; j < kJointCount; ++j) {
      body.position_m[j] = {i >= 20 && i < 30 ? 1.6F : 0.1F, 0.2F, 2.5F};
      body.tracking_state[j] = 2;
    }
    if (i < 45) body.position_m[static_cast<std::size_t>(Joint::wrist_left)] = {0.0F, 0.0F, 0.0F};
    body.position_m[static_cast<std::size_t>(Joint::head)] = {0.0F, 0.0F, i < 2 ? 0.39F : 10.01F};
    frame.bodies.resize(1);
    return true;
  }));
  EXPECT_THAT(said, HasSubstr("error 105 joints lie nearer than 0.4 m or farther than 10 m of the sensor "
                              "(head 60, wrist_left 45) and count as not seen"));
  EXPECT_THAT(said, HasSubstr("warning 2 times a body moves more than 1 m from one frame to the next"));
  EXPECT_THAT(said, testing::Not(HasSubstr("hold no body")));
}

// The sensor whose arrivals jump is named, and no other for ending earlier.
TEST(Session, VerifyNamesArrivalsWhoseClockWasSet) {
  const auto path = scratch("clock_set.h5");
  SessionWriter writer(path, header_of(2));
  for (std::int64_t i = 0; i < 300; ++i)
    for (const std::size_t sensor : {0U, 1U}) {
      BodyFrame frame = body_frame_of(i, 1);
      if (sensor == 1 && i >= 150) frame.stamp.arrival_ns += 5'000'000'000;
      writer.add_body_frame(sensor, frame);
    }
  writer.finish();
  const std::string said = said_of(path);
  EXPECT_THAT(said, HasSubstr("error arrivals jump by 5.00 s, 5.0 s after its first frame"));
  EXPECT_THAT(said, Not(HasSubstr("ends")));
  EXPECT_THAT(said, Not(HasSubstr("began anew")));
}

// From frame 10 on the same body comes seven times more, then every other one twice.
TEST(Session, VerifyCountsBodiesThatAreGivenAgain) {
  const auto repeats = [](std::int64_t first, std::int64_t count) {
    return [=](std::int64_t i, BodyFrame& frame) {
      if (i > first && i <= first + count) frame.bodies = body_frame_of(first, 1).bodies;
      return true;
    };
  };
  EXPECT_THAT(said_of(written("stale.h5", 60, repeats(10, 7))),
              HasSubstr("7 bodies repeat the one before to the last bit"));
  EXPECT_THAT(said_of(written("stale_end.h5", 60, repeats(50, 100))),
              HasSubstr("9 bodies repeat the one before"));
  EXPECT_THAT(said_of(written("doubled.h5", 60,
                              [](std::int64_t i, BodyFrame& frame) {
                                frame.bodies = body_frame_of(i - i % 2, 1).bodies;
                                return true;
                              })),
              Not(HasSubstr("repeat")));
  EXPECT_THAT(said_of(written("constant.h5", 60, repeats(-1, 100))), Not(HasSubstr("repeat")));
}

TEST(Session, ABodyIsGivenToNoOtherFrameThanItsOwn) {
  const auto path = written("hole.h5", 100);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t counts = H5Dopen2(file, "/sensors/k0/body_frames/body_count", H5P_DEFAULT);
  std::vector<std::uint8_t> values(100, 1);
  std::fill(values.begin() + 32, values.begin() + 64, std::uint8_t{0});
  H5Dwrite(counts, H5T_NATIVE_UINT8, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Dclose(counts);
  H5Fclose(file);
  EXPECT_THAT([&] { SessionReader(path).body_frames(0, 0, 100); },
              testing::ThrowsMessage<InputError>(
                  HasSubstr("row 32 is of frame 32, and by the sum of body_count of frame 64")));
  EXPECT_THAT(said_of(path), HasSubstr("error row 32 is of frame 32"));
}

TEST(Session, VerifyNamesASensorThatEndsBeforeTheOthers) {
  const auto path = scratch("ends.h5");
  SessionWriter writer(path, header_of(2));
  for (std::int64_t i = 0; i < 300; ++i) {
    writer.add_body_frame(0, body_frame_of(i, 1));
    if (i < 90) writer.add_body_frame(1, body_frame_of(i, 1));
  }
  writer.finish();
  EXPECT_THAT(said_of(path), HasSubstr("error ends 7.0 s before the last of the others"));
}

TEST(Session, NoticesEndAtALimitAndTheRestIsRead) {
  const auto path = written("notices.h5", 10, {}, [](SessionWriter& writer) {
    for (std::uint64_t i = 0; i < kMaxSessionNotices + 100; ++i)
      writer.add_notice(0, {static_cast<std::int64_t>(i), "no frame"});
  });
  const SessionReader session(path);
  const std::vector<SensorNotice> notices = session.notices(0);
  ASSERT_EQ(notices.size(), kMaxSessionNotices);
  EXPECT_EQ(notices.front().text, "no frame");
  EXPECT_THAT(notices.back().text, HasSubstr("no more are stored"));
  EXPECT_EQ(session.counts(0).notices_left_out, 0u);  // the writer stored no more
  EXPECT_THAT(said_of(path), Not(HasSubstr("are left out")));
}

// A recording sees nobody only if every sensor has body frames and none of them has a body.
TEST(Session, SeesNobodyWhereFramesOfBodiesAreEmpty) {
  const auto recorded = [&](const char* name, int bodies, bool second_has_frames) {
    const auto path = scratch(name);
    SessionWriter writer(path, header_of(2));
    for (std::int64_t i = 0; i < 5; ++i) {
      writer.add_body_frame(0, body_frame_of(i, 0));
      if (second_has_frames) writer.add_body_frame(1, body_frame_of(i, bodies));
    }
    writer.finish();
    return has_no_bodies(SessionReader(path));
  };
  EXPECT_TRUE(recorded("no_person.h5", 0, true));
  EXPECT_FALSE(recorded("one_person.h5", 1, true));
  EXPECT_FALSE(recorded("no_frames.h5", 0, false));
}

TEST(Session, VerifyRefusesLossesThatAreNoCounts) {
  for (const DropCount& drops :
       {DropCount{1, -5, 0}, DropCount{1, 0, -1}, DropCount{1, INT64_MAX, INT64_MAX}})
    EXPECT_THAT(
        said_of(written("drops.h5", 10, {}, [&](SessionWriter& writer) { writer.add_drop_count(0, drops); })),
        HasSubstr(std::to_string(drops.at_source) + " frames lost at the source and " +
                  std::to_string(drops.in_queue) + " because the queue was full are no counts"));
}

TEST(Session, VerifyCountsWhatItFinds) {
  const auto change = [](std::int64_t i, BodyFrame& frame) {
    if (i == 2 || i == 5) frame.bodies.clear();
    if (i == 4) frame.stamp.device_ticks = body_frame_of(3, 1).stamp.device_ticks;
    if (i == 7) {
      frame.bodies[0].tracking_state[3] = 2;
      frame.bodies[0].position_m[3][1] = std::numeric_limits<float>::infinity();
    }
    return i != 6;
  };
  const std::string said = said_of(written("counted.h5", 9, change, [](SessionWriter& writer) {
    writer.add_clock_exchange(0, {10, 20, 10, 40});
    writer.add_clock_exchange(0, {10, 20, 30, 40});
  }));
  for (const char* finding :
       {"2 of 8 frames hold no body", "1 frames are missing by their sequence numbers",
        "device ticks do not rise at 1 places", "1 tracked or inferred joints are not finite",
        "1 of 2 exchanges run backwards"})
    EXPECT_THAT(said, HasSubstr(finding));
}

TEST(Session, VerifyWarnsWhereNoFrameHoldsABodyAndSaysHowFarItIs) {
  const auto path = written("empty_frames.h5", 5, [](std::int64_t, BodyFrame& frame) {
    frame.bodies.clear();
    return true;
  });
  EXPECT_THAT(said_of(path), HasSubstr("warning 5 of 5 frames hold no body"));
  EXPECT_THAT(said_of(written("one_body.h5", 5,
                              [](std::int64_t i, BodyFrame& frame) {
                                if (i > 0) frame.bodies.clear();
                                return true;
                              })),
              HasSubstr("note 4 of 5 frames hold no body"));
  std::vector<double> shares;
  verify_session(SessionReader(path), {}, [&](double share) { shares.push_back(share); });
  ASSERT_FALSE(shares.empty());
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_NEAR(shares.back(), 1.0, 1e-12);
}

// No clock drifts by half a percent.
TEST(Session, TicksThatDriftAsNoClockDoesAreSaidInPartsPerMillion) {
  const auto path = written("drifting_ticks.h5", 120, [](std::int64_t i, BodyFrame& frame) {
    frame.stamp.arrival_ns = 1'000'000'000 + 33'333'300 * i;
    frame.stamp.device_ticks = static_cast<std::int64_t>(1.005 * 333'333.0 * static_cast<double>(i));
    return true;
  });
  EXPECT_THAT(said_of(path), HasSubstr("warning ticks drift by -4975 ppm against arrivals"));
}

TEST(Session, TimesBeyondSeventyThreeYearsAreNotRead) {
  const std::int64_t most_ticks = (std::int64_t{1} << 61) / header_of(1).sensors[0].tick_ns;
  for (const auto& [share, is_read] : {std::pair{0.9, true}, {1.1, false}}) {
    const auto path = written("far_ticks.h5", 1, [&](std::int64_t, BodyFrame& frame) {
      frame.stamp.device_ticks = static_cast<std::int64_t>(share * static_cast<double>(most_ticks));
      return true;
    });
    const SessionReader session(path);
    const std::string text = message_of([&] { session.stamps(0, FrameStream::bodies, 0, 1); });
    EXPECT_EQ(text == "no error", is_read) << share << ": " << text;
  }
}

TEST(Session, ControlCharactersOfAFileReachNoTerminal) {
  EXPECT_EQ(printable("a\x1b[31m\x7f\n\tb\xc3\xa4"), "a\\x1b[31m\\x7f\n\tb\xc3\xa4");
  EXPECT_STREQ(InputError("f\x1b", "is \x07").what(), "f\\x1b: is \\x07");
  const auto path = scratch("names.h5");
  SessionHeader header = header_of(1);
  header.sensors[0].name = "a\x1b[31m";
  SessionWriter writer(path, header);
  writer.add_body_frame(0, body_frame_of(0, 1));
  writer.finish();
  EXPECT_THAT([&] { SessionReader{path}; },
              testing::ThrowsMessage<InputError>(HasSubstr("control characters")));
}

TEST(Session, VerifySaysWhichStudiesAFindingEndangers) {
  const auto twin = [](std::int64_t i, BodyFrame& frame) {
    if (i == 0) frame.bodies.push_back(frame.bodies[0]);
    return i != 1;
  };
  const std::string said = said_of(written("endangered.h5", 3, twin, [](SessionWriter& writer) {
    writer.add_drop_count(0, {5, 1, 7});
    writer.add_notice(0, {6, "unplugged"});
  }));
  for (const char* finding :
       {"error 1 bodies have the id of another in the same frame | accuracy studies with several",
        "warning 1 frames are missing by their sequence numbers | coverage of every study",
        "warning 1 frames were lost at the source and 7 because the queue was full",
        "note the recorder said: unplugged | \n"})
    EXPECT_THAT(said, HasSubstr(finding));
}

TEST(Session, VerifySaysNothingOfASoundRecording) {
  const auto sound = [](std::int64_t i, BodyFrame& frame) {
    frame.bodies[0].position_m = standing_body().position_m;
    for (auto& position_m : frame.bodies[0].position_m) position_m[2] += 1e-3f * static_cast<float>(i);
    return true;
  };
  EXPECT_EQ(said_of(written("sound.h5", 600, sound)),
            "note no clock exchanges: the sensor is taken to share the recording machine's clock | \n");
}

TEST(Session, VerifyCountsHowOftenTicksBeganAnew) {
  EXPECT_THAT(said_of(written("restarts.h5", 900,
                              [](std::int64_t i, BodyFrame& frame) {
                                if (i >= 300) frame.stamp.device_ticks -= 300 * 333'333;
                                if (i >= 600) frame.stamp.device_ticks -= 300 * 333'333;
                                return true;
                              })),
              HasSubstr("its ticks began anew 2 times while recording"));
}

TEST(Session, NamesOfSensorsAreNamesOfGroups) {
  for (const std::string name : {"", "a/b"}) {
    SessionHeader header = header_of(1);
    header.sensors[0].name = name;
    EXPECT_THAT(message_of([&] { SessionWriter writer(scratch("names.h5"), header); }),
                HasSubstr("must have 1 to 64 characters and no '/'"));
  }
}

TEST(Session, VerifyKnowsARestartFromDisorder) {
  // the sequence begins anew after ten frames, and ticks go on from `ticks`
  const auto with_restart = [](const char* name, std::int64_t ticks) {
    return said_of(written(name, 20, [=](std::int64_t i, BodyFrame& frame) {
      frame = body_frame_of(i + 1000, 1);
      if (i >= 10) frame.stamp.sequence = i - 10;
      if (i >= 10) frame.stamp.device_ticks = ticks + (i - 10) * 333'333;
      return true;
    }));
  };
  EXPECT_THAT(with_restart("restart.h5", 500), HasSubstr("warning sequence numbers begin anew at 1 places"));
  const std::string disorder = with_restart("disorder.h5", 1000 + 1010 * 333'333);
  EXPECT_THAT(disorder, HasSubstr("error sequence numbers do not rise at 1 places"));
  EXPECT_THAT(disorder, Not(HasSubstr("begin anew")));
}

TEST(Session, VerifySaysThatAComputerCouldNotKeepUp) {
  EXPECT_THAT(said_of(written("behind.h5", 600,
                              [](std::int64_t i, BodyFrame& frame) {
                                frame.stamp.arrival_ns += i * 10'700'000;
                                return true;
                              })),
              HasSubstr("and whether the computer kept up"));
}

TEST(Session, VerifySaysHowFarFramesLieFromExchanges) {
  EXPECT_THAT(said_of(written(
                  "outside.h5", 900, {},
                  [](SessionWriter& writer) {
                    for (std::int64_t i = 0; i < 20; ++i) {
                      const std::int64_t t_ns = 5'000'000'000 + i * 250'000'000;
                      writer.add_clock_exchange(0, {t_ns, t_ns + 200'000, t_ns + 250'000, t_ns + 450'000});
                    }
                  })),
              HasSubstr("warning frames lie up to 25.2 s from any exchange"));
}

// The library takes a wrong checksum for a writer at work and, left to itself, would wait for centuries.
TEST(SessionReader, ADamagedSuperblockIsRefusedAtOnce) {
  const auto path = written("superblock.h5", 1);
  std::string bytes = read_file(path);
  bytes.at(44) = static_cast<char>(bytes.at(44) ^ 0x5a);  // of the checksum
  write_file(path, bytes);
  EXPECT_THAT(message_of([&] { SessionReader reader(path); }), HasSubstr("is not a readable HDF5 file"));
}

}  // namespace
}  // namespace trilat
