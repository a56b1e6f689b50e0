// SPDX-License-Identifier: MIT
#include <atomic>
#include <cmath>
#include <concepts>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/philox.h"
#include "datasets/base/time.h"
#include "datasets/base/units.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

template <class A, class B>
concept Subtractable = requires(A a, B b) {
  a - b;
};
template <class A, class B>
concept Comparable = requires(A a, B b) {
  a < b;
};

// Shards that begin at once write the same file.
TEST(WriteFile, SeveralWritersAtOnceLeaveOneWholeFile) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder / "run.json";
  const std::string text(100'000, 'x');
  std::atomic<int> failures = 0, cut = 0;
  {
    std::vector<std::jthread> writers;
    for (int k = 0; k < 4; ++k)
      writers.emplace_back([&] {
        for (int n = 0; n < 50; ++n) try {
            write_file(path, text);
            if (read_file(path, 1u << 20) != text) ++cut;
          } catch (const InputError&) {
            ++failures;
          }
      });
  }
  EXPECT_EQ(failures, 0);
  EXPECT_EQ(cut, 0);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(Time, TwoClocksCanBeNeitherSubtractedNorCompared) {
  static_assert(Subtractable<HostTime, HostTime>);
  static_assert(!Subtractable<HostTime, SensorTime>);
  static_assert(!Subtractable<MocapTime, HostTime>);
  static_assert(!Comparable<HostTime, MocapTime>);
  EXPECT_EQ((HostTime{5} - HostTime{3}).ns, 2);
}

TEST(Time, AClockMapAndItsInverseReturnToTheSameNanosecond) {
  const ClockMap<HostClock, SensorClock> host_from_sensor{{1'000'000'000'000}, {77}, 30e-6};
  const SensorTime t{1'600'000'000'123};
  EXPECT_EQ(host_from_sensor(t).ns, 77 + 600'000'000'123 + 18'000'000);
  EXPECT_NEAR(static_cast<double>(host_from_sensor.inverse()(host_from_sensor(t)).ns - t.ns), 0.0, 1.0);
}

TEST(Philox, GivesThePublishedKnownAnswers) {
  EXPECT_THAT(philox4x32_10({0, 0, 0, 0}, {0, 0}),
              testing::ElementsAre(0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u));
  EXPECT_THAT(philox4x32_10({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
              testing::ElementsAre(0x408f276du, 0x41c83b0eu, 0xa20bc7c6u, 0x6d5451fdu));
  EXPECT_THAT(philox4x32_10({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
              testing::ElementsAre(0xd16cfe09u, 0x94fdccebu, 0x5001e420u, 0x24126ea1u));
}

TEST(Philox, NormalsHaveTheMomentsOfANormal) {
  const RandomStream stream{42, Purpose::test, 7};
  double sum = 0, sum2 = 0, sum4 = 0;
  constexpr int kDraws = 200'000;
  for (std::uint32_t i = 0; i < kDraws; ++i) {
    const double x = stream.normal(i);
    sum += x;
    sum2 += x * x;
    sum4 += x * x * x * x;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 4.0 / std::sqrt(kDraws));
  EXPECT_NEAR(sum2 / kDraws, 1.0, 4.0 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(sum4 / kDraws, 3.0, 4.0 * std::sqrt(96.0 / kDraws));
}

TEST(Philox, UniformsLieInsideTheOpenUnitInterval) {
  const RandomStream stream{1, Purpose::test, 0};
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    EXPECT_GT(stream.uniform(i), 0.0);
    EXPECT_LT(stream.uniform(i), 1.0);
  }
}

TEST(Philox, TheLargestAndTheSmallestBitsLieInsideToo) {
  EXPECT_LT(open_unit(~0U, ~0U), 1.0);
  EXPECT_GT(open_unit(0, 0), 0.0);
}

TEST(Philox, EveryPartOfTheKeyChangesTheNumber) {
  const RandomStream base{1, Purpose::test, 1};
  EXPECT_NE(base.uniform(0), base.uniform(1));
  EXPECT_NE(base.uniform(0), (RandomStream{2, Purpose::test, 1}.uniform(0)));
  EXPECT_NE(base.uniform(0), (RandomStream{1, Purpose::joint_noise, 1}.uniform(0)));
  EXPECT_NE(base.uniform(0), (RandomStream{1, Purpose::test, 2}.uniform(0)));
  EXPECT_NE(random_item(1, 0, 0, 0), random_item(0, 1, 0, 0));
  EXPECT_THROW(random_item(0, 1u << 10, 0, 0), InternalError);
}

TEST(ContentHash, IsSha256) {
  EXPECT_EQ(hash_of_text(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hash_of_text("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(ContentHash, OfAMissingFileNamesIt) {
  try {
    hash_of_file("/nonexistent/file");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.place(), "/nonexistent/file");
  }
}

TEST(Units, KnowEveryLengthUnitOfAnExport) {
  EXPECT_EQ(metres_per(*length_unit_from_text("Meters")), 1.0);
  EXPECT_EQ(metres_per(*length_unit_from_text("Centimeters")), 0.01);
  EXPECT_EQ(metres_per(*length_unit_from_text("Millimeters")), 0.001);
  EXPECT_EQ(metres_per(*length_unit_from_text("inches")), 0.0254);
  EXPECT_EQ(metres_per(*length_unit_from_text("Feet")), 0.3048);
  EXPECT_FALSE(length_unit_from_text("furlongs"));
  EXPECT_FALSE(length_unit_from_text(""));
}

TEST(Files, AWrittenFileReadsBackAndLeavesNoPartial) {
  const ScratchFolder folder;
  const auto path = folder / "file.txt";
  write_file(path, "one\n");
  write_file(path, "two\n");
  EXPECT_EQ(read_file(path), "two\n");
  EXPECT_FALSE(std::filesystem::exists(partial_name(path)));
}

TEST(Files, AFolderThatCannotBeWrittenIsNamed) {
  EXPECT_THROW(write_file("/nonexistent/folder/x", "y"), InputError);
  EXPECT_THROW(read_file("/nonexistent/x"), InputError);
}

TEST(Check, ThrowsWithFileAndLine) {
  try {
    TRILAT_CHECK(1 == 2, "one is two");
    FAIL();
  } catch (const InternalError& error) {
    EXPECT_THAT(error.what(), testing::MatchesRegex("base_test\\.cpp:[0-9]+: one is two"));
  }
}

TEST(WriteFile, WhatCannotBePutInPlaceLeavesNothingBeside) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "taken/by");
  EXPECT_THROW(write_file(folder / "taken", "text"), OutputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "taken.partial"));
}

}  // namespace
}  // namespace trilat
