// SPDX-License-Identifier: MIT
// `trilat import` and `trilat export` as a person meets them.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/skeleton/skeleton.h"
#include "tests/pipeline/program.h"

namespace trilat {
namespace {

using testing::HasSubstr;

std::string rows(int count, int first = 0) {
  std::string text;
  for (int i = first; i < first + count; ++i) {
    text += std::to_string(333'333 * i);
    for (int j = 0; j < kJointCount; ++j) text += ",0.1,0.2,2.5,2";
    text += ",\n";
  }
  return text;
}

TEST(Exchange, AnImportedSessionIsSoundAndIsExported) {
  const ScratchFolder folder;
  const std::string csv = file_with(folder, "a.csv", rows(3)), session = folder / "session.h5";
  const Ended import = run_trilat(folder, {"import", "labanotation", csv, "-o", session, "--json"});
  ASSERT_EQ(import.code, 0) << import.err;
  EXPECT_EQ(only_json(import)["sensors"][0]["body_frames"], 3);
  EXPECT_EQ(run_trilat(folder, {"verify", session}).code, 0);

  const Ended trc =
      run_trilat(folder, {"export", "trc", session, "-o", folder / "a.trc", "--unit", "m", "--json"});
  ASSERT_EQ(trc.code, 0) << trc.err;
  EXPECT_EQ(only_json(trc)["files"][0]["rows"], 3);
  EXPECT_THAT(read_file(folder / "a.trc"), HasSubstr("1\t0.000000\t0.100000\t0.200000\t2.500000"));
  const Ended exported = run_trilat(folder, {"export", "csv", session, "-o", folder / "b.csv"});
  EXPECT_EQ(exported.code, 0) << exported.err;
  EXPECT_THAT(exported.out, HasSubstr("75 rows"));
}

TEST(Exchange, RowsThatAreLeftOutAreExitCodeOneAndSaid) {
  const ScratchFolder folder;
  const std::string csv = file_with(folder, "a.csv", rows(2) + "1,2,3\n" + rows(1, 2));
  const Ended import = run_trilat(folder, {"import", "labanotation", csv, "-o", folder / "session.h5"});
  EXPECT_EQ(import.code, 1) << import.err;
  EXPECT_THAT(import.out, HasSubstr("1 left out; first: " + csv + ":3 has 3 cells"));
}

TEST(Exchange, WhatCannotBeMeantIsRefusedAndLeavesNothing) {
  const ScratchFolder folder;
  const std::string csv = file_with(folder, "a.csv", "no,row\n"), session = folder / "session.h5";
  expect_refused(run_trilat(folder, {"import", "labanotation", csv, "-o", session}), csv);
  expect_refused(run_trilat(folder, {"import", "bvh", csv, "-o", session}),
                 "labanotation, node-kinect2, ntu");
  expect_refused(run_trilat(folder, {"import", "png", csv, "-o", session, "--rate-hz", "30"}),
                 "--depth-unit-mm");
  expect_refused(run_trilat(folder, {"export", "trc", csv, "-o", folder / "a.trc"}), csv);
  EXPECT_FALSE(std::filesystem::exists(session));
  EXPECT_FALSE(std::filesystem::exists(session + ".partial"));
  expect_refused(run_trilat(folder, {"import", "labanotation", csv, "-o", csv}), "never an input");
}

TEST(Exchange, HelpListsEveryFormat) {
  const ScratchFolder folder;
  const Ended help = run_trilat(folder, {"import", "--help"});
  for (const char* format : {"kimore", "labanotation", "node-kinect2", "ntu", "png", "umons-taichi", "xef"})
    EXPECT_THAT(help.out, HasSubstr(std::string("  ") + format + "  "));
  EXPECT_THAT(help.out, HasSubstr("Example: trilat import"));
}

}  // namespace
}  // namespace trilat
