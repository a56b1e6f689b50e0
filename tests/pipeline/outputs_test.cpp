// SPDX-License-Identifier: MIT
// What every verb that writes something does with what stands under that name already.
#include <map>

#include <gmock/gmock.h>

#include "datasets/results/items.h"
#include "pipeline/cli/check_output.h"
#include "tests/pipeline/program.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Words = std::vector<std::string>;

enum class Older { replaced, kept };  // what becomes of an older output of this verb

struct Verb {
  const char* name;
  Words words;         // "@" stands for the folder of the data
  std::string option;  // that names the output
  bool folder;         // or a file
  Words inputs;        // what the verb reads, none of which may be the output
  Older older = Older::replaced;
  bool runs = true;         // in a moment; else only refusals are looked at
  bool forces = true;       // it replaces what others wrote; a history is only ever continued
  std::string gone = {};    // what the verb uses up, or leaves beside: removed before it is run
  std::string copied = {};  // what it uses up, made anew of the session before it is run
};

void PrintTo(const Verb& verb, std::ostream* out) { *out << verb.name; }

const std::string kSession = "@/campaign/p01-walking/session.h5";

std::vector<Verb> verbs() {
  return {
      {"calibrate", {"calibrate", kSession, "--method", "bodies"}, "-o", false, {kSession}},
      {"record",
       {"record", "--source", "synthetic:1,depth=no,duration=0.2,speed=max"},
       "-o",
       false,
       {},
       Older::kept},
      {.name = "record --truth",
       .words = {"record", "--source", "synthetic:1,depth=no", "--duration-s", "0.2", "-o", "@/new.h5"},
       .option = "--truth",
       .folder = true,
       .inputs = {},
       .gone = "@/new.h5"},
      {"simulate", {"simulate", "@/spec/simulation.json"}, "-o", true, {"@/spec/simulation.json", "@/spec"}},
      {"simulate --shard",
       {"simulate", "@/spec/simulation.json", "--shard", "1/1"},
       "-o",
       true,
       {"@/spec/simulation.json", "@/spec"}},
      {"run",
       {"run", "@/study.json", "--campaign", "@/campaign"},
       "-o",
       true,
       {"@/study.json", "@/campaign", "@/campaign/p01-walking"}},
      {"run --shard",
       {"run", "@/study.json", "--campaign", "@/campaign", "--shard", "1/1"},
       "-o",
       true,
       {"@/study.json", "@/campaign"}},
      {"report", {"report", "@/results"}, "-o", true, {"@/results", "@/results/samples.h5"}},
      {"merge", {"merge", "@/part"}, "-o", true, {"@/part"}},
      {"merge of a campaign", {"merge", "@/recordings"}, "-o", true, {"@/recordings"}, Older::kept},
      {.name = "recover",
       .words = {"recover", "@/broken.h5.partial"},
       .option = "-o",
       .folder = false,
       .inputs = {"@/broken.h5.partial"},
       .older = Older::kept,
       .copied = "@/broken.h5.partial"},
      {"reproduce", {"reproduce"}, "-o", true, {}, Older::replaced, false},
      {"gate --junit",
       {"gate", "@/results", "--baseline", "@/results"},
       "--junit",
       false,
       {"@/results/summary.json"}},
      {"gate --history",
       {"gate", "@/results", "--baseline", "@/results"},
       "--history",
       false,
       {"@/results/summary.json"},
       Older::replaced,
       true,
       false},
  };
}

// Every file under `folder` with its bytes, every link with where it leads.
std::map<std::string, std::string> everything_in(const fs::path& folder) {
  std::map<std::string, std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    std::string& what = found[entry.path().string()];
    if (entry.is_symlink())
      what = "-> " + fs::read_symlink(entry.path()).string();
    else if (entry.is_regular_file())
      what = read_file(entry.path());
  }
  return found;
}

class Outputs : public testing::TestWithParam<Verb> {
 protected:
  void SetUp() override {
    if (data_) return;
    data_ = new fs::path(fs::path(testing::TempDir()) / ("trilat_outputs_" + std::to_string(getpid())));
    fs::create_directories(*data_ / "spec");
    write_file(*data_ / "spec/simulation.json", R"({"format": "trilat.simulation", "version": 1,
      "participants": 1, "activities": [{"name": "walking", "duration_s": 3}],
      "sensor": {"dropped_share": 0}})");
    write_file(*data_ / "study.json", R"({"format": "trilat.study", "version": 1, "kind": "accuracy",
      "name": "test", "methods": [{"method": "mean"}, {"method": "median"}]})");
    for (const Words& words : std::vector<Words>{
             {"simulate", "@/spec/simulation.json", "-o", "@/campaign"},
             {"simulate", "@/spec/simulation.json", "--shard", "1/1", "-o", "@/recordings"},
             {"run", "@/study.json", "--campaign", "@/campaign", "-o", "@/results"},
             {"run", "@/study.json", "--campaign", "@/campaign", "--shard", "1/1", "-o", "@/part"}}) {
      const Ended ended = run_trilat(folder_, filled(words));
      ASSERT_EQ(ended.code, 0) << ended.err;
    }
    fs::copy_file(*data_ / "campaign/p01-walking/session.h5", *data_ / "broken.h5.partial");
  }
  static void TearDownTestSuite() {
    fs::remove_all(*data_);
    delete data_;
  }

  static std::string filled(std::string word) {
    if (const std::size_t at = word.find('@'); at != std::string::npos) word.replace(at, 1, data_->string());
    return word;
  }
  static Words filled(Words words) {
    for (std::string& word : words) word = filled(word);
    return words;
  }

  static void prepare() {
    const Verb& verb = GetParam();
    if (!verb.gone.empty()) fs::remove(filled(verb.gone));
    if (!verb.copied.empty())
      fs::copy_file(filled(kSession), filled(verb.copied), fs::copy_options::skip_existing);
  }

  Ended write_to(const fs::path& output, bool force = false) const {
    const Verb& verb = GetParam();
    prepare();
    Words words = filled(verb.words);
    words.insert(words.end(), {verb.option, output.string()});
    if (force) words.push_back("--force");
    return run_trilat(folder_, words);
  }

  // Exit code 2, one line, and every byte is where it was.
  void expect_kept(const fs::path& output, const std::string& message, bool force = false) const {
    prepare();
    const auto before = everything_in(*data_), outputs = everything_in(out());
    expect_refused(write_to(output, force), message);
    EXPECT_TRUE(everything_in(*data_) == before) << output;
    EXPECT_TRUE(everything_in(out()) == outputs) << output;
  }

  fs::path out() const {
    fs::create_directories(folder_ / "out");
    return folder_ / "out";
  }

  static inline fs::path* data_ = nullptr;
  ScratchFolder folder_;
};

TEST_P(Outputs, AreNeverAnInputNorALinkToOneWhateverIsForced) {
  for (const std::string& name : GetParam().inputs) {
    const fs::path input = filled(name);
    const bool is_folder = fs::is_directory(input);
    Words names{input.string(), (out() / "link").string()};
    is_folder ? fs::create_directory_symlink(input, names[1]) : fs::create_symlink(input, names[1]);
    if (!is_folder) {
      names.push_back((out() / "hard").string());
      fs::create_hard_link(input, names.back());
    }
    for (const std::string& output : names)
      for (const bool force : {false, true})
        if (!force || GetParam().forces) expect_kept(output, output, force);
    fs::remove_all(out());
  }
}

TEST_P(Outputs, AreNotWrittenOverWhatOthersWroteUnlessForced) {
  const std::string file = file_with(folder_, "notes", "ten years of work");
  const fs::path other_file = out() / "file", other_folder = out() / "folder";
  fs::copy_file(file, other_file);
  fs::create_directory(other_folder);
  fs::copy_file(file, other_folder / "notes");
  const bool folder = GetParam().folder, forces = GetParam().forces;
  expect_kept(other_file, folder ? "is a file" : "--force");
  expect_kept(other_folder, folder ? "--force" : "folder");
  if (!GetParam().runs || !forces) return;
  const Ended ended = write_to(folder ? other_folder : other_file, true);
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(folder ? fs::directory_iterator(other_folder) != fs::directory_iterator()
                     : read_file(other_file) != "ten years of work");
}

TEST_P(Outputs, OfTheSameVerbAreReplacedUnlessTheyAreRecordings) {
  if (!GetParam().runs) return;
  const fs::path output = out() / "own";
  Ended ended = write_to(output);
  ASSERT_EQ(ended.code, 0) << ended.err;
  if (GetParam().older == Older::kept) return expect_kept(output, "--force");
  ended = write_to(output);
  EXPECT_EQ(ended.code, 0) << ended.err;
}

TEST_P(Outputs, MayBeAnEmptyFolder) {
  if (!GetParam().folder || !GetParam().runs) return;
  const Ended ended = write_to(out());
  EXPECT_EQ(ended.code, 0) << ended.err;
}

INSTANTIATE_TEST_SUITE_P(Verbs, Outputs, testing::ValuesIn(verbs()), [](const auto& verb) {
  std::string name;
  for (const char* c = verb.param.name; *c; ++c)
    if (std::isalnum(static_cast<unsigned char>(*c))) name += *c;
  return name;
});

std::string refusal(const fs::path& path, OutputKind kind, const std::string& of = {}) {
  return message_of([&] { check_output({path, kind, {}, false, of}); });
}

TEST(OwnOutputs, APartIsReplacedByPartsOfItsKindOnly) {
  const ScratchFolder folder;
  write_part(folder.path(), {"accuracy", "build", 1, 2, Json::object(), {}});
  EXPECT_THAT(refusal(folder.path(), OutputKind::results), HasSubstr("is not a results folder"));
  EXPECT_THAT(refusal(folder.path(), OutputKind::campaign), HasSubstr("is not an earlier simulation"));
  EXPECT_THAT(refusal(folder.path(), OutputKind::part, "recording"),
              HasSubstr("an earlier part of this kind"));
  EXPECT_EQ(refusal(folder.path(), OutputKind::part, "accuracy"), "no error");
}

TEST(OwnOutputs, ResultsAreKnownWithoutTheOneFileThatAWorkflowEngineRemoves) {
  for (const char* file : {"run", "manifest"}) {
    const ScratchFolder folder;
    for (const char* text : {R"({"format": "another.run"})", "[]", "no JSON"}) {
      file_with(folder, std::string(file) + ".json", text);
      EXPECT_THAT(refusal(folder.path(), OutputKind::results), HasSubstr("is not a results folder")) << text;
    }
    file_with(folder, std::string(file) + ".json", R"({"format": "trilat.)" + std::string(file) + "\"}");
    EXPECT_EQ(refusal(folder.path(), OutputKind::results), "no error");
  }
  const ScratchFolder folder;
  file_with(folder, "items.json", R"({"format": "trilat.items"})");
  EXPECT_THAT(refusal(folder.path(), OutputKind::results), HasSubstr("is not a results folder"));
  file_with(folder, "summary.json", R"({"of": "something else"})");
  EXPECT_THAT(refusal(folder.path(), OutputKind::results), HasSubstr("is not a results folder"));
}

TEST(OwnOutputs, ACampaignThatWasWrittenByHandIsNotASimulation) {
  const ScratchFolder folder;
  file_with(folder, "campaign.json", R"({"format": "trilat.campaign", "simulated": true})");
  EXPECT_THAT(refusal(folder.path(), OutputKind::campaign), HasSubstr("is not an earlier simulation"));
  file_with(folder, "simulator.json", R"({"format": "trilat.simulator"})");
  EXPECT_EQ(refusal(folder.path(), OutputKind::campaign), "no error");
  file_with(folder, "campaign.json", R"({"format": "trilat.campaign", "simulated": false})");
  EXPECT_THAT(refusal(folder.path(), OutputKind::campaign), HasSubstr("is not an earlier simulation"));
}

TEST(OwnOutputs, TheTruthOfAnotherRecordingIsNotReplaced) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder / "truth");
  file_with(folder, "truth/calibration.json",
            R"({"format": "trilat.calibration", "method": "simulated truth"})");
  file_with(folder, "truth/campaign.json",
            R"({"format": "trilat.campaign", "simulated": true, "takes": [{"session": "../s.h5"}]})");
  EXPECT_EQ(refusal(folder / "truth", OutputKind::truth, folder / "s.h5"), "no error");
  EXPECT_THAT(refusal(folder / "truth", OutputKind::truth, folder / "t.h5"), HasSubstr("is not the truth"));
}

TEST(OwnOutputs, WhatIsUnfinishedIsNeverWrittenOverTheInput) {
  const ScratchFolder folder;
  const std::string partial = file_with(folder, "s.csv.partial", "what is read");
  const auto check = [&] { check_output({folder / "s.csv", OutputKind::joint_table, {partial}, true}); };
  EXPECT_THAT(message_of(check), HasSubstr("s.csv: would be written to " + partial));
}

TEST(OwnOutputs, ACalibrationThatWasWrittenByHandIsNotOneOfOurs) {
  const ScratchFolder folder;
  const std::string file =
      file_with(folder, "c.json", R"({"format": "trilat.calibration", "method": "tape"})");
  EXPECT_THAT(refusal(file, OutputKind::calibration), HasSubstr("no calibration of `trilat calibrate`"));
}

}  // namespace
}  // namespace trilat
