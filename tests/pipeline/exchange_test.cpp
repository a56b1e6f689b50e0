// SPDX-License-Identifier: MIT
// `trilat export` as a person meets it, and what `trilat import` says.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/pipeline/program.h"

namespace trilat {
namespace {

using testing::HasSubstr;

TEST(Exchange, ASessionIsExported) {
  const ScratchFolder folder;
  const std::string session = folder / "session.h5";
  const Ended record = run_trilat(
      folder, {"record", "--source", "synthetic:1,depth=no,duration=0.5,speed=max", "-o", session, "--json"});
  ASSERT_EQ(record.code, 0) << record.err;
  const auto rows = only_json(record)["sensors"][0]["body_frames"].get<int>();
  const Ended trc =
      run_trilat(folder, {"export", "trc", session, "-o", folder / "a.trc", "--unit", "m", "--json"});
  ASSERT_EQ(trc.code, 0) << trc.err;
  EXPECT_EQ(only_json(trc)["files"][0]["rows"], rows);
  const Ended exported = run_trilat(folder, {"export", "csv", session, "-o", folder / "b.csv"});
  EXPECT_EQ(exported.code, 0) << exported.err;
  EXPECT_THAT(exported.out, HasSubstr(std::to_string(25 * rows) + " rows"));
  expect_refused(run_trilat(folder, {"export", "trc", folder / "b.csv", "-o", folder / "c.trc"}), "b.csv");
}

TEST(Exchange, ImportSaysWhereItWent) {
  const ScratchFolder folder;
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"import"}, {"import", "ntu", "a.skeleton", "-o", "s.h5", "--json"}})
    expect_refused(run_trilat(folder, words), "import: is not there any more; PYTHONPATH=python python3 -m");
}

}  // namespace
}  // namespace trilat
