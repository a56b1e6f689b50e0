// SPDX-License-Identifier: MIT
// scripts/nightly, with a program that does what a test wants.
#include <gmock/gmock.h>

#include "tests/pipeline/program.h"
#include "tests/support/paths.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::SizeIs;

// A checkout of the script alone, beside a `trilat` that ends with the codes in its folder.
struct Checkout {
  ScratchFolder folder;
  fs::path out = folder / "out";

  Checkout() {
    fs::create_directories(folder / "scripts");
    fs::copy_file(fs::path(kSourceDir) / "scripts/nightly", folder / "scripts/nightly");
    write_script("trilat", R"(here=$(dirname "$0")
verb=$1
code=$(cat "$here/$verb.code" 2>/dev/null || echo 0)
if [[ $verb == reproduce ]]; then mkdir -p "${@: -1}/walk"; fi
if [[ $verb == gate && $code -lt 2 && " $* " == *" --accept "* ]]; then mkdir -p "$(dirname "$2")/../../baseline"; fi
echo "said by $verb: $*"
exit "$code")");
  }
  void write_script(const std::string& name, const std::string& lines) const {
    write_file(folder / name, "#!/usr/bin/env bash\n" + lines + "\n");
    fs::permissions(folder / name, fs::perms::owner_all);
  }
  void ends_with(const std::string& verb, int code) const {
    write_file(folder / (verb + ".code"), std::to_string(code));
  }
  Ended night(const std::string& program = "trilat", const std::string& keep = "14",
              const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"TRILAT_NIGHTLY_DIR=" + out.string(), "TRILAT_NIGHTLY_KEEP=" + keep,
                                   "--chdir=" + folder.path().string()};
    std::swap(words[0], words[2]);  // options of env come first
    words.insert(words.end(), more.begin(), more.end());
    if (!program.empty()) words.push_back("TRILAT_NIGHTLY_PROGRAM=" + program);
    words.push_back((folder / "scripts/nightly").string());
    return Process(folder, words, "", "/usr/bin/env").wait();
  }
  std::size_t nights() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(out / "nights"), fs::directory_iterator()));
  }
  // Names of nights are seconds.
  void age(const std::string& name) const {
    fs::rename(fs::canonical(out / "latest"), out / "nights" / name);
  }
};

TEST(Nightly, AProgramIsFoundFromWhereItWasNamed) {
  const Checkout checkout;
  const Ended ended = checkout.night("./trilat");
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("FIRST NIGHT"));
}

TEST(Nightly, ABuildThatFailsEndsTheNight) {
  const Checkout checkout;
  fs::create_directories(checkout.folder / "build/release");
  fs::copy_file(checkout.folder / "trilat", checkout.folder / "build/release/trilat");
  checkout.write_script("scripts/build", "echo 'no such type'; exit 1");
  const Ended ended = checkout.night("");
  EXPECT_EQ(ended.code, 2) << ended.out;
  EXPECT_THAT(ended.err, testing::AllOf(HasSubstr("no such type"), HasSubstr("building ended with code 1")));
}

TEST(Nightly, AFirstNightWhoseItemsFailedBecomesNoBaseline) {
  const Checkout checkout;
  checkout.ends_with("reproduce", 1);
  const Ended ended = checkout.night();
  EXPECT_EQ(ended.code, 2) << ended.out;
  EXPECT_THAT(ended.err, HasSubstr("items failed in: reproducing"));
  EXPECT_FALSE(fs::exists(checkout.out / "baseline"));
}

TEST(Nightly, ALostBaselineIsNotTakenForAFirstNight) {
  for (const char* left : {"history.csv", "baseline.old", "baseline.partial"}) {
    const Checkout checkout;
    fs::create_directories(checkout.out);
    write_file(checkout.out / left, "");
    const Ended ended = checkout.night();
    EXPECT_EQ(ended.code, 2) << left;
    EXPECT_THAT(ended.err, HasSubstr("this is not the first night")) << left;
  }
}

TEST(Nightly, WhatCannotBeAcceptedOrJudgedIsNotCalledABaselineOrARegression) {
  const Checkout checkout;
  checkout.ends_with("gate", 2);
  Ended ended = checkout.night();
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.out, testing::Not(HasSubstr("FIRST NIGHT")));
  checkout.ends_with("gate", 137);
  ended = checkout.night();
  EXPECT_EQ(ended.code, 2);
}

TEST(Nightly, AFullDiskIsNoRegression) {
  const Checkout checkout;
  ASSERT_EQ(checkout.night().code, 0);
  checkout.age("2000-01-01T00-00-00Z");
  // the disk is full for what the script says itself
  const std::string night = (checkout.folder / "scripts/nightly").string();
  const Ended ended = Process(checkout.folder,
                              {"-c", "TRILAT_NIGHTLY_DIR=" + checkout.out.string() +
                                         " TRILAT_NIGHTLY_PROGRAM=" + (checkout.folder / "trilat").string() +
                                         " " + night + " >/dev/full"},
                              "", "/bin/bash")
                          .wait();
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.err, HasSubstr("disk full"));
}

TEST(Nightly, TheGateGetsTheOptionsThatAreSetAndNoOthers) {
  const Checkout checkout;
  EXPECT_THAT(checkout.night().out, HasSubstr("history.csv --accept the first night\n"));
  checkout.age("2000-01-01T00-00-00Z");
  EXPECT_THAT(checkout.night().out, HasSubstr("history.csv\n"));
  checkout.age("2000-01-02T00-00-00Z");
  EXPECT_THAT(checkout.night("trilat", "14", {"TRILAT_NIGHTLY_GATE=--smallest-effect 2"}).out,
              HasSubstr("history.csv --smallest-effect 2\n"));
}

TEST(Nightly, ARegressionEndsWithOne) {
  const Checkout checkout;
  ASSERT_EQ(checkout.night().code, 0);
  checkout.age("2000-01-01T00-00-00Z");
  checkout.ends_with("gate", 1);
  EXPECT_EQ(checkout.night().code, 1);
}

TEST(Nightly, ANightThatCannotBeJudgedEndsWithThreeAndIsNoJudgedOne) {
  const Checkout checkout;
  ASSERT_EQ(checkout.night().code, 0);
  checkout.age("2000-01-01T00-00-00Z");
  checkout.ends_with("gate", 3);
  const Ended ended = checkout.night();
  EXPECT_EQ(ended.code, 3) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("said by gate"));
  EXPECT_FALSE(fs::exists(checkout.out / "latest/judged"));
}

TEST(Nightly, NightsThatWereNotJudgedPushNoJudgedOneOut) {
  const Checkout checkout;
  ASSERT_EQ(checkout.night("trilat", "1").code, 0);
  checkout.age("2000-01-01T00-00-00Z");
  checkout.ends_with("gate", 2);
  for (int n = 1; n <= 3; ++n) {
    ASSERT_EQ(checkout.night("trilat", "1").code, 2);
    checkout.age("2000-01-0" + std::to_string(n + 1) + "T00-00-00Z");
  }
  EXPECT_TRUE(fs::exists(checkout.out / "nights/2000-01-01T00-00-00Z"));
  EXPECT_LE(checkout.nights(), 2u);
}

}  // namespace
}  // namespace trilat
