// SPDX-License-Identifier: MIT
#include "reports/provenance.h"

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/results/summary.h"
#include "tests/reports/summaries.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

std::string manifest(const std::string& kind, const std::string& name, const std::string& version = "1") {
  return R"({"format": "trilat.manifest", "version": )" + version +
         R"(, "program": "trilat 9", "study": {"kind": ")" + kind + R"(", "name": ")" + name +
         R"(", "seed": 5}, "study_sha256": "ab", "campaign": "hand made", "rig": ["k1", "k2"],)"
         R"( "inputs": [{"take": "t1", "role": "session", "file": "s.h5", "bytes": 1, "sha256": null}]})";
}

struct Folder {
  ScratchFolder scratch;
  ResultsSummary summary = hand_made_summary();
  Folder() { write_summary(scratch.path(), summary); }
  Provenance read() const { return read_provenance(scratch.path(), summary.study, summary.campaign); }
};

TEST(Provenance, TellsConfigurationHashesSeedAndMachine) {
  const Folder folder;
  write_file(folder.scratch / "manifest.json", manifest("accuracy", folder.summary.study));
  write_file(folder.scratch / "run.json",
             R"({"format": "trilat.run", "version": 1, "processor": "P", "threads": 3, "wall_s": 1.25})");
  const Provenance p = folder.read();
  EXPECT_EQ(p.program, "trilat 9");
  EXPECT_EQ(p.seed, "5");
  EXPECT_EQ(p.study_sha256, "ab");
  EXPECT_THAT(p.rig, testing::ElementsAre("k1", "k2"));
  ASSERT_EQ(p.inputs.size(), 1u);
  EXPECT_EQ(p.inputs[0].sha256, "");
  EXPECT_EQ(p.processor, "P");
  EXPECT_EQ(p.threads, "3");
  EXPECT_THAT(p.config, HasSubstr("\"kind\": \"accuracy\""));
  EXPECT_THAT(commands_of(p), HasSubstr("trilat run " + study_file(p) + " --campaign CAMPAIGN -o "));
}

TEST(Provenance, WithoutAManifestNothingIsClaimed) {
  const Provenance p = Folder().read();
  EXPECT_EQ(p.config, "");
  EXPECT_EQ(p.processor, "");
}

TEST(Provenance, AManifestOfAnotherRunIsRefused) {
  const Folder folder;
  write_file(folder.scratch / "manifest.json", manifest("recording", folder.summary.study));
  EXPECT_THAT(
      message_of([&] { folder.read(); }),
      HasSubstr(
          "manifest.json /study/kind: is \"recording\", and that of summary.json beside it \"accuracy\""));
  write_file(folder.scratch / "manifest.json", manifest("accuracy", "another"));
  EXPECT_THAT(message_of([&] { folder.read(); }), HasSubstr("manifest.json /study/name: is \"another\""));
}

TEST(Provenance, AManifestOfAnotherVersionIsRefused) {
  const Folder folder;
  write_file(folder.scratch / "manifest.json", manifest("accuracy", folder.summary.study, "2"));
  EXPECT_THAT(message_of([&] { folder.read(); }), HasSubstr("manifest.json /version: is another version"));
}

TEST(Provenance, AFolderWrittenWithASlashKeepsItsName) {
  EXPECT_EQ(folder_name("a/b/"), "b");
  EXPECT_EQ(folder_name("a/b"), "b");
}

}  // namespace
}  // namespace trilat
